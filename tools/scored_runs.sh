# SPDX-License-Identifier: GPL-3.0-or-later
# For measure-planning and measure-sweeps, after steps.sh: models that are built, scored on the photographs that were held
# out, and removed, their figures kept. A run that was made is not made again.

program=build/release/tools/lumatlas

usage() {
  echo "usage: $script SCENE [--hold 8] [--block 1] [--views N] [--refine none|exposure] [--only GLOB]" >&2
  trap - EXIT
  exit 2
}

# prepare_runs FOLDER ARGUMENT...: takes the script's arguments and builds the program. Sets scene, hold, block, views,
# refine, only and offered, the number of photographs that are not held out; runs is where runs are kept, below FOLDER.
prepare_runs() {
  local -r folder=$1
  shift
  [ $# -ge 1 ] || usage
  scene=$(cd "$called_from" && realpath -- "$1")
  hold=8 block=1 views="" refine=none only="*"
  shift
  while [ $# -gt 0 ]; do
    [ $# -ge 2 ] || usage
    case $1 in
      --hold) hold=$2 ;;
      --block) block=$2 ;;
      --views) views=$2 ;;
      --refine) refine=$2 ;;
      --only) only=$2 ;;
      *) usage ;;
    esac
    shift 2
  done
  [ "$refine" = none ] || [ "$refine" = exposure ] || usage

  step "Configuring" cmake --preset release
  step "Building" cmake --build --preset release --target lumatlas
  current_step="looking for the number of photographs"
  offered=$(count_offered)
  [ -n "$views" ] || views=$((offered < 4 ? 1 : offered / 4))
  runs=$folder/$(basename "$scene")-hold-$hold-$block-views-$views-$refine
}

# See --hold and --block in README.md.
count_offered() {
  "$program" inspect "$scene" --json --quiet | python3 -c '
import json, sys
hold, block = int(sys.argv[1]), int(sys.argv[2])
count = json.load(sys.stdin)["views"]["count"]
print(sum((rank // block) % hold != 0 for rank in range(count)))' "$hold" "$block"
}

# run NAME OPTION...: builds and scores a model of so many `views`; its figures are kept.
run() {
  local -r name=$1 folder=$runs/$1
  shift
  # shellcheck disable=SC2053  # a pattern
  [[ $name == $only ]] || return 0
  [ ! -f "$folder/scores.json" ] || return 0  # written last
  mkdir -p "$folder"
  step "$name" build_and_score "$folder" "$@"
}

build_and_score() {
  local -r folder=$1
  shift
  "$program" build "$scene" -o "$folder/model" --hold "$hold" --block "$block" --views "$views" --refine "$refine" \
    --json --quiet "$@" >"$folder/build.json"
  "$program" validate "$folder/model" --views "$scene" --baselines none --no-alignment --no-pictures --json --quiet \
    -o "$folder/report" >"$folder/scores.json.part"
  rm -r "$folder/model" "$folder/report"
  mv "$folder/scores.json.part" "$folder/scores.json"
}
