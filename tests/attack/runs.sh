# SPDX-License-Identifier: GPL-3.0-or-later
# Runs of the program, and what must hold after each.

declare -A endings=()
status=0

complain() { complaints+=("$* (command: $(cat "$case_folder/command"))"); }

# run SURROUNDINGS ARGUMENT...: the program after the shell has evaluated SURROUNDINGS; its streams go to `out` and
# `err` in the case's folder, unless SURROUNDINGS redirects them. `how` is what goes before: `timeout` with its options.
how=(timeout -k 5 60)
run() {
  local surroundings=$1
  shift
  printf '%q ' "$program" "$@" >"$case_folder/command"
  if [ -n "$surroundings" ]; then printf '# after: %s' "$surroundings" >>"$case_folder/command"; fi
  # The outer redirection is for what this shell says of signals.
  {
    "${how[@]}" bash -c 'eval "$0"; exec "$@"' "$surroundings" "$program" "$@" \
      >"$case_folder/out" 2>"$case_folder/err" </dev/null
  } 2>/dev/null
  status=$?
}

signal_name() { kill -l "$1"; }

# judge [SIGNAL...]: how the last run ended. SIGNALs are those that it may have died of.
judge() {
  local signal
  if [ "$status" -gt 128 ]; then
    signal=$(signal_name $((status - 128)))
    count "signal $signal"
    if [[ " $* " != *" $signal "* ]]; then complain "died of SIG$signal"; fi
    return
  fi
  count "exit $status"
  case $status in
    0) ;;
    1) judge_sentence ;;
    124) complain "still ran after a minute" ;;
    *) complain "exit status $status: $(head -c 500 "$case_folder/err")" ;;
  esac
}

count() { endings[$1]=$((${endings[$1]:-0} + 1)); }

# One line that begins with the program's name and does not break off.
judge_sentence() {
  local err=$case_folder/err
  if [ -n "${LUMATLAS_ATTACK_LOG:-}" ]; then cat "$err" >>"$LUMATLAS_ATTACK_LOG"; fi
  if [ "$(wc -l <"$err")" -ne 1 ] || [ -n "$(tail -c 1 "$err")" ]; then
    complain "exit 1 and not one line on stderr: $(head -c 1000 "$err")"
  elif ! grep -qaE '^lumatlas: .*[^][ ,:;([-]$|^lumatlas: .*[])]$' "$err"; then
    complain "exit 1 and no whole sentence: $(head -c 1000 "$err")"
  elif grep -qaE '^lumatlas: (\[json\.exception|std::|basic_|vector::|map::|sto[a-z]+$)' "$err"; then
    complain "exit 1 and a sentence that names nothing: $(head -c 1000 "$err")"
  fi
}

# A program that the loader could not even start speaks for itself.
judge_started() {
  if [[ $status == 12[67] ]] && grep -qE 'loading shared libraries|cannot execute|Argument list too long|Cannot allocate' "$case_folder/err"; then
    count "not started by the system"
  else
    judge "$@"
  fi
}

# The files of a folder or file, with their checksums.
sums_of() {
  if [ -d "$1" ]; then
    (cd "$1" && find . -type f -exec sha256sum {} + | sort -k 2)
  else
    sha256sum <"$1"
  fi
}

# put_earlier TARGET: an earlier model where the next run will put its own.
put_earlier() {
  case $1 in
    *.glb) cp "$work/base/earlier.glb" "$1" ;;
    *) cp -r "$work/base/earlier" "$1" ;;
  esac
  earlier_sums=$(sums_of "$1")
}

# The earlier model is as it was, or there is a whole other one.
judge_earlier() {
  local target=$1
  if [ ! -e "$target" ]; then
    complain "the earlier model is gone"
  elif [ "$(sums_of "$target")" != "$earlier_sums" ] && ! "$program" inspect "$target" >/dev/null 2>"$case_folder/inspect"; then
    complain "the earlier model is damaged: $(cat "$case_folder/inspect")"
  elif [ "$status" -eq 0 ] && [ "$(sums_of "$target")" = "$earlier_sums" ]; then
    complain "exit 0, and the earlier model is still there"
  fi
}

# no_leftovers FOLDER
no_leftovers() {
  local left
  left=$(find "$1" -name '.lumatlas-*' | head -n 3)
  if [ -n "$left" ]; then complain "left behind: $left"; fi
}

build_options=(--refine none --quiet)

# The next run succeeds and removes what the last one left.
judge_next_build() {
  local target=$1
  run "" build "$work/base/scene" -o "$target" "${build_options[@]}"
  if [ "$status" -ne 0 ]; then complain "the next build fails: $(cat "$case_folder/err")"; fi
  no_leftovers "$(dirname "$target")"
}

# The scene and models that are attacked: a synthetic scene, the same with its COLMAP model as text, as transforms.json
# and as three programs write their own, videos of it where there is FFmpeg, a model as a folder and in one file, and one
# of fewer photographs that stands for what was there before.
make_base() {
  local base=$work/base
  mkdir "$base"
  "$program" synth apartment -o "$base/scene" --photographs 8 --width 64 --height 48 --samples 2 --triangles 3000 --quiet &&
    "$program" build "$base/scene" -o "$base/model" "${build_options[@]}" &&
    "$program" build "$base/scene" -o "$base/model.glb" "${build_options[@]}" &&
    "$program" build "$base/scene" -o "$base/earlier" --max-views 3 "${build_options[@]}" &&
    "$program" build "$base/scene" -o "$base/earlier.glb" --max-views 3 "${build_options[@]}" &&
    make_text_scene "$base/scene" "$base/text" &&
    make_capture "$base/text" "$base/capture" &&
    "$program" build "$base/capture" -o "$base/capture-model" "${build_options[@]}" &&
    "$program" build "$base/text" -o "$base/text-model" "${build_options[@]}" &&
    make_forms "$base/text" "$base" &&
    make_colmap "$base" && make_videos "$base"
}

# numbers FILE OFFSET BYTES TYPE: of a binary file, as od(1) knows types.
numbers() { od -A n -v -w"$3" -j "$2" -N "$3" -t "$4" "$1"; }

# make_text_scene SCENE TARGET: with cameras.txt and images.txt in the place of its binary files.
make_text_scene() {
  local model images count at=8 id pose camera name points
  cp -r "$1" "$2"
  images=$(find "$2" -name images.bin)
  model=$(dirname "$images")
  numbers "$model/cameras.bin" 8 24 u4 | {
    read -r id _ width _ height _
    echo "$id PINHOLE $width $height $(numbers "$model/cameras.bin" 32 32 f8)"
  } >"$model/cameras.txt"
  count=$(numbers "$images" 0 8 u8)
  for ((i = 0; i < count; ++i)); do
    id=$(numbers "$images" $at 4 u4)
    pose=$(numbers "$images" $((at + 4)) 56 f8)
    camera=$(numbers "$images" $((at + 60)) 4 u4)
    name=$(tail -c +$((at + 65)) "$images" | head -c 4096 | tr '\0' '\n' | head -n 1)
    at=$((at + 64 + ${#name} + 1))
    points=$(numbers "$images" $at 8 u8)
    at=$((at + 8 + 24 * points))
    printf '%d %s %d %s\n\n' "$id" "$(echo $pose)" "$camera" "$name"
  done >"$model/images.txt"
  rm "$model"/*.bin
}

# make_capture TEXT_SCENE TARGET: with transforms.json, whose matrices take from cameras that look along -z with y up to
# the world, in the place of the COLMAP model.
make_capture() {
  local model
  model=$(dirname "$(find "$1" -name images.txt)")
  mkdir "$2" && cp -r "$1/images" "$1/mesh.ply" "$2"
  awk '
    FNR == NR { if ($1 !~ /^#/) { width = $3; height = $4; fx = $5; fy = $6; cx = $7; cy = $8 } next }
    NF == 10 {
      w = $2; x = $3; y = $4; z = $5
      # Rows of the rotation from the world, which are the camera axes in the world.
      r[0] = 1 - 2 * (y * y + z * z); r[1] = 2 * (x * y - w * z); r[2] = 2 * (x * z + w * y)
      r[3] = 2 * (x * y + w * z); r[4] = 1 - 2 * (x * x + z * z); r[5] = 2 * (y * z - w * x)
      r[6] = 2 * (x * z - w * y); r[7] = 2 * (y * z + w * x); r[8] = 1 - 2 * (x * x + y * y)
      frames = frames (frames ? ",\n" : "") "    {\"file_path\": \"images/" $10 "\", \"transform_matrix\": ["
      for (i = 0; i < 3; ++i) {
        center = -(r[i] * $6 + r[3 + i] * $7 + r[6 + i] * $8)
        frames = frames sprintf("[%.17g, %.17g, %.17g, %.17g], ", r[i], -r[3 + i], -r[6 + i], center)
      }
      frames = frames "[0, 0, 0, 1]]}"
    }
    END {
      printf "{\n  \"w\": %d, \"h\": %d, \"fl_x\": %s, \"fl_y\": %s, \"cx\": %s, \"cy\": %s,\n", width, height, fx, fy, cx, cy
      printf "  \"frames\": [\n%s\n  ]\n}\n", frames
    }' "$model/cameras.txt" "$model/images.txt" >"$2/transforms.json"
}

# make_forms TEXT_SCENE FOLDER: opensfm, openmvg and meshroom in FOLDER are scenes with the files of these programs in
# the place of the COLMAP model. Each must be one that the program builds.
make_forms() {
  local model form
  model=$(dirname "$(find "$1" -name images.txt)")
  for form in opensfm:reconstruction.json openmvg:sfm_data.json meshroom:cameras.sfm; do
    mkdir "$2/${form%:*}" && cp -r "$1/images" "$1/mesh.ply" "$2/${form%:*}"
    awk -v form="${form%:*}" -f "$here/forms.awk" "$model/cameras.txt" "$model/images.txt" >"$2/${form%:*}/${form#*:}"
    "$program" build "$2/${form%:*}" -o "$2/${form%:*}-model" "${build_options[@]}" || return
  done
}

# make_colmap FOLDER: bin/colmap in FOLDER is a stand-in for COLMAP that finds the poses of the scene.
make_colmap() {
  local model
  model=$(dirname "$(find "$1/scene" -name images.bin)")
  mkdir "$1/bin"
  cat >"$1/bin/colmap" <<SCRIPT
#!/bin/sh
command=\$1
shift
if [ "\$1" = -h ]; then echo '  --SiftExtraction.use_gpu arg (=1)'; echo '  --SiftMatching.use_gpu arg (=1)'; exit; fi
if [ "\$command" = help ]; then echo '  mapper'; exit; fi
while [ \$# -gt 0 ]; do
  case \$1 in --database_path) database=\$2 ;; --output_path) output=\$2 ;; esac
  shift 2
done
case \$command in
  feature_extractor) echo '  Features:        866'; : >>"\$database" ;;
  *_matcher | matches_importer) echo 'Matching block [1/1, 1/1]' ;;
  mapper) mkdir -p "\$output/0" && cp '$model'/*.bin "\$output/0" ;;
esac
SCRIPT
  chmod +x "$1/bin/colmap"
}

# make_videos FOLDER: walk.mp4 and walk.mkv of the scene's photographs.
make_videos() {
  local name
  if [ -z "$(command -v ffmpeg)" ]; then return 0; fi
  for name in walk.mp4 walk.mkv; do
    ffmpeg -v error -nostdin -y -framerate 4 -pattern_type glob -i "$1/scene/images/*.png" -pix_fmt yuv420p "$1/$name" || return
  done
}
