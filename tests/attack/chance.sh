# SPDX-License-Identifier: GPL-3.0-or-later
# What is chosen by chance, and damage to files by chance. Results are left in `chosen` and not printed: a subshell would
# have a sequence of its own.

# below N: a whole number in [0, N).
below() { chosen=$(((RANDOM * 32768 + RANDOM) % ($1 > 0 ? $1 : 1))); }

one_of() {
  below $#
  shift "$chosen"
  chosen=${1:-}  # of none, nothing
}

# one_file FOLDER [NAME...]: a file of the folder, one of these names if any are given.
one_file() {
  local folder=$1 names=()
  shift
  for name in "$@"; do names+=(${names:+-o} -name "$name"); done
  local files
  mapfile -t files < <(find "$folder" -type f ${names:+\( "${names[@]}" \)} | sort)
  one_of "${files[@]}"
}

hostile_numbers=(0 -0 -1 1e309 -1e308 1e-320 nan inf 0x10 2147483648 4294967295 4294967296 18446744073709551615
  18446744073709551616 999999999999999999999999 1.7976931348623157e308 65537 1e12 3.5 -2147483649 '""' null '[]' '{}' '[[[[' true)
hostile_words=('""' '"../../../../etc/passwd"' '"/etc/passwd"' '"/dev/zero"' '"/proc/self/mem"' '"."' '".."' '"a/../b"'
  '"%2e%2e%2fscene.gltf"' '"data:application/octet-stream;base64,AAAA"' '"data:,"' '"file:///dev/zero"'
  '"http://localhost/a.png"' '"scene.gltf"' '"con\u0000.png"' '"\ud800"' '"%n%s%n"' '"MASK"' '"VEC3"' '"image/gif"' 7 null '[]' '{}')

# replace_token FILE PATTERN REPLACEMENT: one of the places in FILE that match, by chance.
replace_token() {
  local file=$1 places
  mapfile -t places < <(grep -obaE -- "$2" "$file" | cut -c 1-2000)
  if [ ${#places[@]} -eq 0 ]; then return; fi
  one_of "${places[@]}"
  local at=${chosen%%:*} token=${chosen#*:}
  {
    head -c "$at" "$file"
    printf '%s' "$3"
    tail -c +"$((at + ${#token} + 1))" "$file"
  } >"$file.new" && mv "$file.new" "$file"
}

# A number or a text of a JSON file becomes one that no program writes.
hostile_json() {
  local file=$1
  below 3
  if [ "$chosen" -eq 0 ]; then
    one_of "${hostile_words[@]}"
    replace_token "$file" '"[^"]*"' "$chosen"
  else
    one_of "${hostile_numbers[@]}"
    replace_token "$file" '[-+]?[0-9][0-9.]*([eE][-+]?[0-9]+)?' "$chosen"
  fi
}

# A value of a JSON file becomes a thousand lists within each other.
nested_json() {
  replace_token "$1" '[-+]?[0-9][0-9.]*([eE][-+]?[0-9]+)?' "$(printf '[%.0s' {1..1000})$(printf ']%.0s' {1..1000})"
}

# write_bytes FILE OFFSET HEX...: each HEX is one byte.
write_bytes() {
  local file=$1 at=$2
  shift 2
  printf "$(printf '\\\\x%s' "$@")" | dd of="$file" bs=1 seek="$at" conv=notrunc status=none
}

hostile_words_of_boxes=('00 00 00 00' '00 00 00 01' '00 00 00 02' '00 00 00 08' '00 01 00 00' '00 01 00 01' '7f ff ff ff'
  '80 00 00 00' 'ff ff ff ff' 'ff ff ff f0' '00 00 ff ff' '3f ff ff ff' '00 00 40 00')

# replace_box FILE NAME: one of the 32-bit words about a box of this name becomes one that no program writes: its size,
# or one of what it holds.
replace_box() {
  local places word at
  mapfile -t places < <(grep -obaF -- "$2" "$1" | cut -d : -f 1)
  if [ ${#places[@]} -eq 0 ]; then return; fi
  one_of "${places[@]}"
  at=$chosen
  one_of -4 4 8 8 12 12 16 20 24
  at=$((at + chosen))
  if [ "$at" -lt 0 ]; then at=0; fi
  one_of "${hostile_words_of_boxes[@]}"
  word=($chosen)
  write_bytes "$1" "$at" "${word[@]}"
}

# A box of a HEIC file or of an MP4 claims something else.
damage_box() {
  local names=() name
  for name in ftyp meta hdlr pitm iloc iinf infe iprp ipco ipma ispe hvcC pixi iref dimg idat mdat moov mvhd trak tkhd mdia mdhd \
    minf stbl stsd stts stsc stsz stco ctts elst avcC avc1; do
    if grep -qaF -- "$name" "$1"; then names+=("$name"); fi
  done
  if [ ${#names[@]} -eq 0 ]; then return; fi
  one_of "${names[@]}"
  replace_box "$1" "$chosen"
}

# listen_at FILE: makes a socket whose listening process has ended.
listen_at() { python3 -c 'import socket, sys; socket.socket(socket.AF_UNIX).bind(sys.argv[1])' "$1" 2>/dev/null || mkfifo "$1"; }

# The same of a text whose words stand between blanks.
hostile_text() {
  local file=$1
  below 4
  case $chosen in
    0) one_of '../../../etc/passwd' /dev/zero . .. "$(printf 'x%.0s' {1..300})" 'a/../../b' '%n' $'\xff\xfe.jpg' '' ;;
    *) one_of "${hostile_numbers[@]}" ;;
  esac
  replace_token "$file" '[^ ]+' "$chosen"
}

# damage FOLDER [NAME...]: one file of it, in one of many ways.
damage() {
  one_file "$@"
  local file=$chosen size
  if [ -z "$file" ]; then return; fi
  size=$(stat -c %s "$file")
  below 12
  case $chosen in
    0 | 1 | 2 | 3)  # some bytes
      below 4
      local count=$((chosen * chosen + 1)) at
      for ((i = 0; i < count; ++i)); do
        below "$size"
        at=$chosen
        # What is at the beginning says how the rest is to be read.
        if ((i % 2)); then at=$((at % 128)); fi
        one_of 00 01 7f 80 ff 20 2d 0a "$(printf %02x $((RANDOM % 256)))"
        printf "\\x$chosen" | dd of="$file" bs=1 seek="$at" conv=notrunc status=none
      done
      ;;
    4 | 5)  # cut off
      below "$size"
      truncate -s "$chosen" "$file"
      ;;
    6)  # longer than it says
      below 5000
      head -c "$chosen" /dev/zero | tr '\0' 'z' >>"$file"
      ;;
    7)  # in the place of another
      local other
      one_file "$1"
      other=$chosen
      mv "$file" "$file.swapped"
      if [ "$other" != "$file" ]; then mv "$other" "$file"; fi
      mv "$file.swapped" "$other"
      ;;
    8) rm "$file" ;;
    9)
      rm "$file"
      one_of /dev/zero /dev/null "$file" /etc /proc/self/mem /nowhere "$1"
      ln -s "$chosen" "$file"
      ;;
    10)
      rm "$file"
      one_of mkfifo mkdir
      "$chosen" "$file"
      ;;
    11)  # a hole of a gigabyte at its end
      truncate -s 1G "$file"
      ;;
  esac
}
