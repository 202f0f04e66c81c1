# SPDX-License-Identifier: GPL-3.0-or-later
# One function for each kind of attack. Each has an empty folder, $case_folder.

kinds=(scene_files kill text_scene model_files limits model_json streams notes_json full_disk options glb locale
  file_size kill_picture small_disk capture export points kill_export view server web_names half_written closed_streams
  untold_result forms mesh_frame odd_photographs captured kill_capture arrays)

# use_scene FOLDER: what people do with a scene.
use_scene() {
  below 3
  case $chosen in
    0) run "" inspect "$1" --quiet ;;
    *)
      local target=$case_folder/model
      put_earlier "$target"
      run "" build "$1" -o "$target" "${build_options[@]}"
      judge_earlier "$target"
      ;;
  esac
  judge
  no_leftovers "$case_folder"
}

# use_model MODEL: what people do with a model.
use_model() {
  below 5
  case $chosen in
    0 | 1 | 2) run "" inspect "$1" ;;
    3) run "" render "$1" --orbit --frames 1 --width 32 --height 24 --quiet -o "$case_folder/pictures" ;;
    4) run "" validate "$1" --views "$work/base/scene" --quiet ;;
  esac
  judge
  no_leftovers "$case_folder"
}

damage_sometimes_twice() {
  damage "$@"
  below 3
  if [ "$chosen" -eq 0 ]; then damage "$@"; fi
}

case_scene_files() {
  cp -r "$work/base/scene" "$case_folder/scene"
  below 2
  if [ "$chosen" -eq 0 ]; then
    damage_sometimes_twice "$case_folder/scene"
  else
    damage_sometimes_twice "$case_folder/scene" 'cameras.bin' 'images.bin' '*.ply'
  fi
  use_scene "$case_folder/scene"
}

case_text_scene() {
  cp -r "$work/base/text" "$case_folder/scene"
  one_file "$case_folder/scene" cameras.txt images.txt
  hostile_text "$chosen"
  use_scene "$case_folder/scene"
}

# The same photographs with transforms.json instead of a COLMAP model.
case_capture() {
  cp -r "$work/base/capture" "$case_folder/scene"
  below 3
  case $chosen in
    0) damage_sometimes_twice "$case_folder/scene" transforms.json mesh.ply ;;
    *) hostile_json "$case_folder/scene/transforms.json" ;;
  esac
  use_scene "$case_folder/scene"
}

case_points() {
  cp -r "$work/base/scene" "$case_folder/scene"
  below 4
  if [ "$chosen" -ne 0 ]; then damage_sometimes_twice "$case_folder/scene" points3D.bin images.bin cameras.bin; fi
  below 4
  if [ "$chosen" -eq 0 ]; then set -- "ulimit -f 1; trap '' XFSZ"; else set -- ""; fi
  run "$1" mesh "$case_folder/scene" -o "$case_folder/made.ply" --quiet
  judge
  if [ "$status" -ne 0 ] && [ -e "$case_folder/made.ply" ]; then complain "half an output stands at its place"; fi
  no_leftovers "$case_folder"
}

# some_export: leaves in `exported` options of one of the forms that a model may be exported to, into the case's folder.
some_export() {
  one_of made.glb made-gltf made-obj made-web made.html
  exported=(-o "$case_folder/$chosen" --quiet)
  case $chosen in
    made.glb) exported+=(--texture 1024) ;;
    made-gltf) exported+=(--to gltf --texture 512 --pages 4) ;;
    made-obj) exported+=(--to obj --texture 1024) ;;
    *) exported+=(--to web) ;;
  esac
  made=$case_folder/$chosen
}

judge_export() {
  judge "$@"
  if [ "$status" -ne 0 ] && [ -e "$made" ]; then complain "half an output stands at its place"; fi
  if [ "$status" -eq 0 ] && [ ! -e "$made" ]; then complain "exit 0 and no output"; fi
}

# An export of a damaged model, or onto a disk that becomes full.
case_export() {
  cp -r "$work/base/model" "$case_folder/model"
  local surroundings=""
  below 3
  case $chosen in
    0) below 200; surroundings="trap '' XFSZ; ulimit -f $((chosen + 1))" ;;
    1) hostile_json "$case_folder/model/tileset.json" ;;
    2) damage_sometimes_twice "$case_folder/model" ;;
  esac
  some_export
  run "$surroundings" export "$case_folder/model" "${exported[@]}"
  judge_export
  no_leftovers "$case_folder"
}

case_kill_export() {
  some_export
  kill_later 2000
  run "" export "$work/base/model" "${exported[@]}"
  how=(timeout -k 5 60)
  judge_export "$sent"
  if [ "$sent" = KILL ]; then
    run "" export "$work/base/model" "${exported[@]}"
    judge_export
  fi
  no_leftovers "$case_folder"
}

# A server ends by the signal, or in peace on Ctrl-C.
case_view() {
  cp -r "$work/base/model" "$case_folder/model"
  below 2
  if [ "$chosen" -eq 0 ]; then damage_sometimes_twice "$case_folder/model"; fi
  one_of --quiet --follow
  local options=(--no-browser "$chosen")
  kill_later 3000
  run "" view "$case_folder/model" "${options[@]}"
  how=(timeout -k 5 60)
  judge_loud "$sent"
  no_leftovers "$case_folder"
}

# ask PORT REQUEST [SECONDS]: sends the bytes that printf makes of REQUEST, and leaves what is answered within that time
# in `answer` in the case's folder.
ask() {
  timeout "${3:-2}" bash -c 'exec 3<>"/dev/tcp/127.0.0.1/$0" && printf %b "$1" >&3 && cat <&3' "$1" "$2" \
    >"$case_folder/answer" 2>/dev/null
}

# The answer to the last ask is a whole one, to a GET.
judge_answer() {
  local answer=$case_folder/answer head length
  head=$(head -c 2000 "$answer" | tr -d '\0' | sed '/^\r$/q')
  if ! head -n 1 "$answer" | grep -qaE $'^HTTP/1\\.[01] [2-5][0-9]{2} [A-Za-z -]*\r$'; then
    complain "no well-formed answer to $1: $(head -c 200 "$answer")"
    return
  fi
  length=$(sed -n $'s/^Content-Length: \\([0-9]*\\)\r$/\\1/p' <<<"$head")
  if [ "$(($(wc -c <"$answer") - ${#head} - 1))" -ne "${length:--1}" ]; then
    complain "another length than it says, to $1: $head"
  fi
}

body_of_answer() { tail -c +$(($(sed $'/^\r$/q' "$case_folder/answer" | wc -c) + 1)) "$case_folder/answer"; }

# A request that a browser would not send. It is left in `request`, for printf.
strange_request() {
  local host="Host: localhost\\r\\n" end="Connection: close\\r\\n\\r\\n" method=GET path=/tileset.json line value
  one_of $'Range: bytes=' Host: Content-Length: Transfer-Encoding: Expect: X: $'Range: bytes=0-1,' Connection:
  line=$chosen
  one_of "${hostile_numbers[@]}" 0-0 5-1 -1 0- 99999999999- '0-0,0-0' 18446744073709551615-18446744073709551616 \
    evil.example 127.0.0.1 chunked 100-continue close keep-alive "$(printf 'x%.0s' {1..9000})" '\\0' '\\n' ' ' ''
  value=$chosen
  below 4
  case $chosen in
    0) one_of POST PUT DELETE OPTIONS TRACE PATCH CONNECT PRI get '' '\\x16\\x03\\x01' "$(printf 'G%.0s' {1..20000})"; method=$chosen ;;
    1) one_of /../../etc/passwd /%2e%2e/etc/passwd //etc/passwd http://evil.example/ '*' '' '/\\0' '/?a=b' "/$(printf 'x%.0s' {1..20000})"; path=$chosen ;;
  esac
  request="$method $path HTTP/1.1\\r\\n$host$line $value\\r\\n$end"
}

# A range of the file that stands as `whole` in the case's folder is answered with these bytes of it.
judge_range() {
  local port=$1 size first last
  size=$(stat -c %s "$case_folder/whole")
  below $((size + 10))
  first=$chosen
  below $((2 * size))
  last=$((first + chosen))
  ask "$port" "GET /tileset.json HTTP/1.1\\r\\nHost: localhost\\r\\nRange: bytes=$first-$last\\r\\nConnection: close\\r\\n\\r\\n"
  judge_answer "a range"
  if [ "$first" -ge "$size" ]; then
    if ! head -n 1 "$case_folder/answer" | grep -qa ' 416 '; then complain "a range past the end is answered"; fi
  elif ! cmp -s <(body_of_answer) <(tail -c +$((first + 1)) "$case_folder/whole" | head -c $((last - first + 1))); then
    complain "bytes $first-$last of $size are not the file's"
  fi
}

# judge_serves PORT: the whole page comes at once.
judge_serves() {
  ask "$1" 'GET /tileset.json HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' 5
  judge_answer "a whole request"
  if ! cmp -s <(body_of_answer) "$case_folder/whole"; then complain "the server no longer answers as it did"; fi
}

# start_server: leaves the process of `view` in `server`, its port in `port`, and tileset.json as it answers it as `whole`
# in the case's folder.
start_server() {
  local i
  printf '%q ' "$program" view "$work/base/model" --no-browser --quiet >"$case_folder/command"
  "$program" view "$work/base/model" --no-browser --quiet >"$case_folder/out" 2>"$case_folder/err" </dev/null &
  server=$!
  for ((i = 0; i < 600; ++i)); do
    if [ -s "$case_folder/out" ] || ! kill -0 "$server" 2>/dev/null; then break; fi
    sleep 0.05
  done
  port=$(sed -n 's|^http://127.0.0.1:\([0-9]*\)/$|\1|p' "$case_folder/out")
  ask "${port:-0}" 'GET /tileset.json HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' 5
  body_of_answer >"$case_folder/whole"
  if ! [ -s "$case_folder/whole" ]; then complain "the server does not answer"; fi
}

# hold_connections PORT: opens 40 connections with half a request or none, which stay until they are killed or for a
# minute.
hold_connections() {
  exec timeout 60 bash -c 'for ((i = 0; i < 40; ++i)); do
      exec {half}<>"/dev/tcp/127.0.0.1/$0" && if ((i % 2)); then printf "GET /tileset.json HT" >&"$half"; fi
    done
    read -r -u "$half"' "$1" 2>/dev/null
}

# The server that `view` is, by clients that no browser is.
case_server() {
  local server port halves i
  start_server
  hold_connections "$port" &
  halves=$!
  for ((i = 0; i < 6; ++i)); do
    strange_request
    ask "$port" "$request" 1
    if [ -s "$case_folder/answer" ] && [[ $request != HEAD* ]]; then judge_answer "$(head -c 200 <<<"$request")"; fi
    judge_range "$port"
  done
  judge_serves "$port"
  kill "$halves" 2>/dev/null
  wait "$halves" 2>/dev/null
  judge_serves "$port"
  kill -TERM "$server" 2>/dev/null
  wait "$server" 2>/dev/null
  status=$?
  judge TERM
  no_leftovers "$case_folder"
}

# Names that would be something else in HTML, in a URL or in the page's template.
case_web_names() {
  local name target page title
  one_of 'a{{data}}b' '{{script}}' '{{style}}{{title}}' '<script>alert(1)<' '"><b>' "'" '&lt;' $'a\nb' $'\xff\xfe' '%2e%2e' \
    'a b?c#d' '-x' '$(id)' '`id`' '.' "$(printf 'n%.0s' {1..200})"
  name=$chosen
  mkdir "$case_folder/in"
  cp -r "$work/base/model" "$case_folder/in/$name"
  if [ "$name" = . ]; then cp -r "$work/base/model/." "$case_folder/in"; fi
  one_of site.html site
  target=$case_folder/$chosen
  if [ "$name" != . ]; then target=$case_folder/$name${chosen#site}; fi
  run "" export "$case_folder/in/$name" --to web --quiet -o "$target"
  judge
  if [ "$status" -ne 0 ]; then
    complain "a name stops it: $(cat "$case_folder/err")"
    return
  fi
  page=$target
  if [ -d "$target" ]; then page=$target/index.html; fi
  title=$(tr '\n' ' ' <"$page" | grep -aoP -m 1 '<title>.*?</title>')
  if [[ ${title#<title>} == *"<"*"</title>" ]]; then complain "the title is more than a text: ${title:0:300}"; fi
  if ! grep -qaE '<script type="?module' "$page"; then complain "the page has no script"; fi
  if [ -d "$target" ]; then
    # All files that the page or the scene names are there.
    while read -r file; do
      if [ ! -f "$target/$file" ]; then complain "$file is named and not there"; fi
    done < <(grep -aohE '[a-z0-9/-]+-[0-9a-f]{16}\.[a-z]+' "$page" "$target/tileset.json" | sort -u)
  elif [ "$(grep -ac 'data-file="' "$page")" -lt 10 ]; then
    complain "the page lacks its data"
  fi
  no_leftovers "$case_folder"
}

case_model_files() {
  cp -r "$work/base/model" "$case_folder/model"
  damage_sometimes_twice "$case_folder/model"
  use_model "$case_folder/model"
}

# Numbers of a model that other numbers of it limit. By chance alone they would seldom be chosen among thousands.
model_fields=(cellSize depthEdge edgeRadius fade size gutter width height)

case_model_json() {
  local file=$case_folder/model/tileset.json field
  cp -r "$work/base/model" "$case_folder/model"
  below 2
  if [ "$chosen" -eq 0 ]; then
    one_of "${model_fields[@]}"
    field=$chosen
    one_of 1000 1e6 1e300 "${hostile_numbers[@]}"
    replace_token "$file" "\"$field\": [-+0-9.eE]+" "\"$field\": $chosen"
  else
    hostile_json "$file"
  fi
  use_model "$case_folder/model"
}

case_notes_json() {
  cp -r "$work/base/model" "$case_folder/model"
  one_file "$case_folder/model" plan.json lumatlas.json
  hostile_json "$chosen"
  use_model "$case_folder/model"
}

case_glb() {
  cp "$work/base/model.glb" "$case_folder/model.glb"
  damage_sometimes_twice "$case_folder" model.glb
  use_model "$case_folder/model.glb"
}

# soon MILLISECONDS: leaves a moment within these in `moment`, as timeout(1) wants it.
soon() {
  below "$1"
  printf -v moment '%d.%03d' $((chosen / 1000)) $((chosen % 1000))
}

# Sends one of the signals after a while, and once: timeout would send it to a whole group otherwise.
kill_later() {
  one_of KILL TERM INT HUP PIPE
  sent=$chosen
  soon "$1"
  how=(timeout --preserve-status --foreground -s "$sent" -k 15 "$moment")
}

case_kill() {
  local target
  one_of model model.glb
  target=$case_folder/$chosen
  put_earlier "$target"
  kill_later 1500
  run "" build "$work/base/scene" -o "$target" "${build_options[@]}"
  how=(timeout -k 5 60)
  judge "$sent"
  judge_earlier "$target"
  if [ "$sent" != KILL ]; then no_leftovers "$case_folder"; fi
  judge_next_build "$target"
}

case_kill_picture() {
  kill_later 2500
  one_of synth render
  case $chosen in
    synth) run "" synth wall -o "$case_folder/made" --photographs 20 --width 96 --height 64 --quiet ;;
    render) run "" render "$work/base/model" --orbit --frames 20 --width 160 --height 120 --quiet -o "$case_folder/made" ;;
  esac
  how=(timeout -k 5 60)
  judge "$sent"
  if [ "$sent" != KILL ]; then
    no_leftovers "$case_folder"
    if [ "$status" -ne 0 ] && [ -e "$case_folder/made" ]; then complain "half an output stands at its place"; fi
  fi
}

case_limits() {
  local surroundings target=$case_folder/model
  put_earlier "$target"
  below 4
  case $chosen in
    0 | 1) below 4000000; surroundings="ulimit -v $((chosen + 20000))" ;;
    2) below 8000; surroundings="ulimit -s $((chosen + 200))" ;;
    3) below 60; surroundings="ulimit -n $((chosen + 3))" ;;
  esac
  run "$surroundings" build "$work/base/scene" -o "$target" "${build_options[@]}"
  judge_started
  judge_earlier "$target"
  judge_next_build "$target"
}

case_streams() {
  local surroundings target=$case_folder/model
  put_earlier "$target"
  one_of '>&-' '2>&-' '<&-' '>&- 2>&- <&-' '>/dev/full' '2>/dev/full' '> >(exit)' '2> >(exit)' '</dev/zero'
  surroundings="exec $chosen"
  one_of --json --verbose
  run "$surroundings" build "$work/base/scene" -o "$target" --refine none "$chosen"
  # Without a whole stderr there is nothing to be judged but the status.
  if [[ $surroundings == *2\>* && $status == 1 ]]; then count "exit 1"; else judge_loud PIPE; fi
  judge_earlier "$target"
  judge_next_build "$target"
}

# As judge, of a run that tells its progress too: the last line is the sentence.
judge_loud() {
  tail -n 1 "$case_folder/err" >"$case_folder/err.last" && mv "$case_folder/err.last" "$case_folder/err"
  judge "$@"
}

# A limit on the size of files, which stands for a disk that becomes full: one kilobyte at least, for the sentence. The
# signal that comes with it is sent by the system, and must not end the program.
case_file_size() {
  local trap_it target
  one_of model model.glb
  target=$case_folder/$chosen
  put_earlier "$target"
  one_of "trap '' XFSZ" :
  trap_it=$chosen
  below 120
  run "$trap_it; ulimit -f $((chosen + 1))" build "$work/base/scene" -o "$target" "${build_options[@]}"
  judge
  judge_earlier "$target"
  no_leftovers "$case_folder"
  judge_next_build "$target"
}

case_full_disk() {
  local trap_it="trap '' XFSZ"
  below 60
  local blocks=$chosen
  one_of synth render build
  case $chosen in
    synth) run "$trap_it; ulimit -f $((1 + blocks / 8))" synth wall -o "$case_folder/made" --photographs 2 --width 96 --height 64 --quiet ;;
    render) run "$trap_it; ulimit -f $((1 + blocks / 8))" render "$work/base/model" --orbit --frames 2 --width 96 --height 64 --quiet -o "$case_folder/made" ;;
    build) run "$trap_it; ulimit -f $((1 + blocks))" build "$work/base/scene" -o "$case_folder/made" "${build_options[@]}" ;;
  esac
  judge
  if [ "$status" -ne 0 ] && [ -e "$case_folder/made" ]; then complain "half an output stands at its place"; fi
  no_leftovers "$case_folder"
}

# A file system that has room for the earlier model, and by chance for another one or a part of it, where mounting one is
# allowed.
case_small_disk() {
  local target=$disk/model kilobytes
  mkdir -p "$disk"
  kilobytes=$(du -sk "$work/base/earlier" | cut -f 1)
  below $((2 * kilobytes))
  kilobytes=$((kilobytes + 100 + chosen))
  if ! mount -t tmpfs -o size="${kilobytes}k" lumatlas-attack "$disk" 2>/dev/null; then
    count "not run: mount"
    return
  fi
  put_earlier "$target"
  run "" build "$work/base/scene" -o "$target" "${build_options[@]}"
  judge
  judge_earlier "$target"
  no_leftovers "$disk"
  umount "$disk"
}

case_locale() {
  local surroundings target=$case_folder/model name
  one_of garbage C POSIX tr_TR.UTF-8 de_DE.UTF-8 ja_JP.eucJP $(locale -a) "$(printf '%0500d' 0)" ../../etc ''
  name=$chosen
  one_of ":" "export TZ=garbage" "unset HOME PATH" "export TMPDIR=/nowhere" "export OMP_NUM_THREADS=-1 COLUMNS=-5" \
    "export OPENIMAGEIO_OPTIONS=threads=-1,x" "cd /; umask 777"
  surroundings="export LANG=$(printf %q "$name") LC_ALL=$(printf %q "$name"); $chosen"
  if [[ $chosen == *umask* ]]; then surroundings=${surroundings/umask 777/umask 077}; fi
  run "$surroundings" build "$work/base/scene" -o "$target" "${build_options[@]}"
  judge
  if [ "$status" -ne 0 ]; then
    complain "surroundings that are none of its business stop it"
  elif ! cmp -s "$target/tileset.json" "$work/base/model/tileset.json"; then  # it names all others by their content
    complain "another model than elsewhere"
  fi
}

# Values that make no sense: exit 2 with a sentence, unless they happen to be good.
case_options() {
  local options=(--max-views --cell-size --set=coverage.references --hold --block --set=stream.seed --max-cells --tile-size
    --set=coverage.ideal-distance --loss --budget --refine --set=coverage.metric --image --quality --set=stream.order
    --set --set=tiles --set=tiles.tile=16)
  local option value
  one_of "${options[@]}"
  option=$chosen
  one_of 0 -1 1 2 nan inf 1e309 1e-300 99999999999999999999 '' ' ' x '1 2' 0x10 ../.. $'\xff' $'a\nb' none all auto 1KiB
  value=$chosen
  run "" build "$work/base/scene" -o "$case_folder/model" "${build_options[@]}" "$option=$value"
  if [ "$status" -eq 2 ]; then
    count "exit 2"
    if ! [ -s "$case_folder/err" ]; then complain "exit 2 without a word"; fi
    if [ -e "$case_folder/model" ]; then complain "exit 2 and an output"; fi
  else
    judge
  fi
  no_leftovers "$case_folder"
}

# photographs_in MODEL: how many photographs it was made of.
photographs_in() { grep -oE '"offered": [0-9]+' "$1/plan.json" | head -n 1 | grep -oE '[0-9]+'; }

# A scene that is watched while some of its photographs are half written, until Ctrl-C at any moment: the earlier model
# stays unless most photographs came.
case_half_written() {
  local target=$case_folder/model photograph size
  cp -r "$work/base/scene" "$case_folder/scene"
  put_earlier "$target"
  for photograph in "$case_folder/scene/images/"*; do
    below 4
    if [ "$chosen" -eq 0 ]; then continue; fi
    size=$(stat -c %s "$photograph")
    truncate -s $((size * chosen / 4)) "$photograph"
  done
  soon 6000
  how=(timeout --preserve-status --foreground -s INT -k 15 "$moment")
  run "" build "$case_folder/scene" -o "$target" --watch "${build_options[@]}"
  how=(timeout -k 5 60)
  judge_loud INT
  judge_earlier "$target"
  if [ "$(sums_of "$target")" != "$earlier_sums" ] && [ "$(photographs_in "$target")" -lt 4 ]; then
    complain "a model of $(photographs_in "$target") of 8 photographs is in the place of the earlier one"
  fi
  no_leftovers "$case_folder"
}

# Any of the three streams is closed, for any command: no file gets the numbers 0 to 2.
case_closed_streams() {
  local streams=() made=$case_folder/made
  for stream in '<&-' '>&-' '2>&-'; do
    below 2
    if [ "$chosen" -eq 0 ]; then streams+=("$stream"); fi
  done
  local surroundings=":"
  if [ ${#streams[@]} -gt 0 ]; then surroundings="exec ${streams[*]}"; fi
  below 4
  case $chosen in
    0) run "$surroundings" build "$work/base/scene" -o "$made" --refine none ;;
    1) run "$surroundings" render "$work/base/model" --orbit --frames 1 --mode depth --width 32 --height 24 -o "$made" ;;
    2) run "$surroundings" export "$work/base/model" --to web -o "$made" ;;
    3) run "$surroundings" inspect "$work/base/model" ;;
  esac
  if [[ $surroundings == *2\>* && $status == 1 ]]; then count "exit 1"; else judge_loud; fi
  if [ "$status" -eq 0 ] && [[ $surroundings == *" >&-"* ]]; then complain "exit 0, and the result was not told"; fi
  if [ "$status" -eq 1 ] && [[ $surroundings != *">&-"* ]]; then complain "fails although it can tell its result"; fi
  no_leftovers "$case_folder"
}

# Standard output takes no result: what the sentence calls complete is there.
case_untold_result() {
  local made
  one_of made made.glb
  made=$case_folder/$chosen
  one_of --json --quiet
  run "exec >/dev/full" build "$work/base/scene" -o "$made" --refine none "$chosen"
  judge_loud
  if [ "$status" -ne 1 ]; then complain "exit status $status, and the result was not told"; fi
  if ! grep -q "is complete, but" "$case_folder/err"; then complain "does not say what is left"; fi
  if ! "$program" inspect "$made" >/dev/null 2>&1; then complain "the output that is called complete is not"; fi
  no_leftovers "$case_folder"
}

# The scene as OpenSfM, OpenMVG or Meshroom writes it, with a value that none of them writes.
case_forms() {
  local form
  one_of opensfm openmvg meshroom
  form=$chosen
  cp -r "$work/base/$form" "$case_folder/scene"
  one_file "$case_folder/scene" '*.json' '*.sfm'
  local file=$chosen
  below 4
  case $chosen in
    0) damage_sometimes_twice "$case_folder/scene" "$(basename "$file")" mesh.ply ;;
    1) nested_json "$file" ;;
    *) hostile_json "$file" ;;
  esac
  use_scene "$case_folder/scene"
}

# A mesh in another frame than the poses, by options that are mostly good, and by chance not.
case_mesh_frame() {
  local target=$case_folder/model options=()
  one_of 0.001 1 1e3 1e-300 1e300 "${hostile_numbers[@]}"
  local scale=$chosen
  one_of x,y,z x,-z,y -y,-x,-z y,z,x x,x,x x,y '' x,y,z,x -,-,- 'x, y, z' x,y,w +x,+y,+z $'x,y,z\n' "$(printf 'x,%.0s' {1..999})"
  local axes=$chosen
  one_of 0,0,0 1,-2,3 -500000,-4500000,0 1e308,-1e308,1e308 1e-320,0,0 nan,0,0 inf,0,0 1,2 1,2,3,4 '' , ',,' 0x1,0,0 '1;2;3'
  local shift=$chosen
  below 7
  if [ $(((chosen + 1) & 1)) -ne 0 ]; then options+=("--mesh-scale=$scale"); fi
  if [ $(((chosen + 1) & 2)) -ne 0 ]; then options+=("--mesh-axes=$axes"); fi
  if [ $(((chosen + 1) & 4)) -ne 0 ]; then options+=("--mesh-shift=$shift"); fi
  below 2
  if [ "$chosen" -eq 0 ]; then
    run "" inspect "$work/base/scene" --quiet "${options[@]}"
  else
    run "" build "$work/base/scene" -o "$target" "${build_options[@]}" "${options[@]}"
  fi
  if [ "$status" -eq 2 ]; then
    count "exit 2"
    if ! [ -s "$case_folder/err" ]; then complain "exit 2 without a word"; fi
  else
    judge
  fi
  if [ "$status" -ne 0 ] && [ -e "$target" ]; then complain "half an output stands at its place"; fi
  no_leftovers "$case_folder"
}

# odd_photograph FILE: something in the place of a photograph or video that is none, or that claims another size.
odd_photograph() {
  local file=$1
  rm -rf "$file"
  below 10
  case $chosen in
    0 | 1 | 2) cp "$here/photograph.heic" "$file" && damage_box "$file" ;;
    3) cp "$here/photograph.heic" "$file" && replace_box "$file" ispe ;;
    4) mkfifo "$file" ;;
    5) one_of 5 7 9; mknod "$file" c 1 "$chosen" 2>/dev/null || ln -s /dev/zero "$file" ;;  # zero, full, urandom
    6) one_of /dev/zero /dev/full /dev/random /dev/tty /dev/stdin /proc/self/mem /proc/kmsg . "$file" && ln -s "$chosen" "$file" ;;
    7) mkdir "$file" && touch "$file/a.jpg" ;;
    8) listen_at "$file" ;;
    9) cp "$here/photograph.heic" "$file" && truncate -s "$((RANDOM % 2000))" "$file" ;;
  esac
}

# Photographs that are none, or whose boxes claim other sizes than their pictures have.
case_odd_photographs() {
  local photographs count i
  cp -r "$work/base/scene" "$case_folder/scene"
  mapfile -t photographs < <(find "$case_folder/scene/images" -type f | sort)
  below 3
  count=$((chosen + 1))
  for ((i = 0; i < count; ++i)); do
    one_of "${photographs[@]}"
    odd_photograph "$chosen"
  done
  use_scene "$case_folder/scene"
}

# make_inputs FOLDER: what people hold for a folder of photographs: the scene's own, two videos, and a HEIC one.
make_inputs() {
  mkdir "$1"
  cp "$work/base/scene/images/"* "$1"
  cp "$work/base/walk.mp4" "$work/base/walk.mkv" "$1" 2>/dev/null
  cp "$here/photograph.heic" "$1/extra.heic"
}

# Photographs and videos of which some are damaged or none, with a COLMAP that places the scene's own.
case_captured() {
  local inputs=$case_folder/photographs target=$case_folder/model file count i
  make_inputs "$inputs"
  below 3
  count=$((chosen + 1))
  for ((i = 0; i < count; ++i)); do
    below 6
    case $chosen in
      0) damage "$inputs" '*.heic' '*.mp4' '*.mkv' ;;
      1) odd_photograph "$inputs/extra.heic" ;;
      2) one_of .mp4 .mov .heic .jpg .avif .dng .webm && odd_photograph "$inputs/new$chosen" ;;
      *)
        one_file "$inputs" '*.mp4' '*.mkv'
        file=$chosen
        if [ -z "$file" ]; then continue; fi
        below 3
        case $chosen in
          0) damage "$inputs" "$(basename "$file")" ;;
          *) damage_box "$file" ;;
        esac
        ;;
    esac
  done
  # FFmpeg reads a hole of a gigabyte byte by byte, for minutes.
  find "$inputs" -type f -size +20M -exec truncate -s 20M {} +
  put_earlier "$target"
  run "export PATH=$work/base/bin:\$PATH" capture "$inputs" -o "$target" --from points --max-frames 4 --quiet
  judge_captured
  judge_earlier "$target"
  no_leftovers "$case_folder"
}

# Judges as `judge` does, but allows warnings before the sentence.
judge_captured() {
  grep -v '^warning: ' "$case_folder/err" >"$case_folder/err.told"
  mv "$case_folder/err.told" "$case_folder/err"
  judge "$@"
}

# A capture that is ended at any moment leaves no program of its own running, and the next one ends well.
case_kill_capture() {
  local inputs=$case_folder/photographs target=$case_folder/model
  make_inputs "$inputs"
  put_earlier "$target"
  kill_later 3000
  run "export PATH=$work/base/bin:\$PATH" capture "$inputs" -o "$target" --from points --max-frames 4 --quiet
  how=(timeout -k 5 60)
  judge_captured "$sent"
  judge_earlier "$target"
  sleep 0.5
  if [ "$sent" != KILL ] && pgrep -f "$case_folder" >/dev/null; then complain "left running: $(pgrep -af "$case_folder")"; fi
  run "export PATH=$work/base/bin:\$PATH" capture "$inputs" -o "$target" --from points --max-frames 4 --quiet
  if [ "$status" -ne 0 ]; then complain "the next capture fails: $(cat "$case_folder/err")"; fi
  no_leftovers "$case_folder"
}

# Arrays and numbers that Python gives the module, where LUMATLAS_ATTACK_PYTHON can import it.
case_arrays() {
  if ! "${LUMATLAS_ATTACK_PYTHON:-/nowhere}" -c 'import numpy, lumatlas' 2>/dev/null; then
    count "not run: Python"
    return
  fi
  local program=$LUMATLAS_ATTACK_PYTHON
  mkdir "$case_folder/temporary"
  run "export TMPDIR=$case_folder/temporary; ulimit -v 6000000" "$here/arrays.py" "$seed" "$number" "$work/base/scene"
  judge
  no_leftovers "$case_folder"
}
