# SPDX-License-Identifier: GPL-3.0-or-later
# For the scripts beside it: a title before each step, the step's output kept in a log, and the first failure named.
# The script sets `script` to its own name before it sources this.
set -euo pipefail

root=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")
cd "$root"
mkdir -p out/log
rm -f out/log/"${script##*/}"-*.log
exec </dev/null  # nothing here asks anything

current_step="the start"
current_log=""
step_count=0
step_times=()  # "SECONDS TITLE" of the steps that are done

say_what_failed() {
  local -r status=$?
  if [ $status -ne 0 ]; then
    echo >&2
    echo "$script: failed (exit status $status) at: $current_step." >&2
    [ -z "$current_log" ] || echo "$script: everything this step said is in $root/$current_log" >&2
  fi
}
trap say_what_failed EXIT
trap 'exit 130' INT TERM

# step TITLE COMMAND...
step() {
  current_step=$1
  shift
  step_count=$((step_count + 1))
  current_log=$(printf 'out/log/%s-%d.log' "${script##*/}" $step_count)
  printf '\n== %s\n' "$current_step"
  local -r start=$SECONDS
  "$@" 2>&1 | tee "$current_log"
  step_times+=("$(printf '%5d s  %s' $((SECONDS - start)) "$current_step")")
  printf '== done in %d s\n' $((SECONDS - start))
}

# say_times: a table of where the time went.
say_times() {
  printf '\n'
  printf '%s\n' "${step_times[@]}"
  printf '%5d s  together\n' $SECONDS
}
