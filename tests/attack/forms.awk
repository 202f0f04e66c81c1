# SPDX-License-Identifier: GPL-3.0-or-later
# cameras.txt and images.txt of COLMAP, as what FORM writes: opensfm, openmvg or meshroom.

function list(values, count, quote,   i, text) {
  for (i = 0; i < count; ++i) text = text (i ? ", " : "") quote sprintf("%.17g", values[i]) quote
  return "[" text "]"
}

FNR == NR {
  if ($1 !~ /^#/) { width = $3; height = $4; fx = $5; fy = $6; cx = $7; cy = $8 }
  next
}

NF == 10 {
  w = $2; x = $3; y = $4; z = $5; name = $10
  # Rows of the rotation from the world.
  r[0] = 1 - 2 * (y * y + z * z); r[1] = 2 * (x * y - w * z); r[2] = 2 * (x * z + w * y)
  r[3] = 2 * (x * y + w * z); r[4] = 1 - 2 * (x * x + z * z); r[5] = 2 * (y * z - w * x)
  r[6] = 2 * (x * z - w * y); r[7] = 2 * (y * z + w * x); r[8] = 1 - 2 * (x * x + y * y)
  for (i = 0; i < 3; ++i) {
    center[i] = -(r[i] * $6 + r[3 + i] * $7 + r[6 + i] * $8)
    translation[i] = $(6 + i)
    for (k = 0; k < 3; ++k) by_columns[3 * i + k] = r[3 * k + i]
  }
  sine = sqrt(x * x + y * y + z * z)
  angle = 2 * atan2(sine, w)
  turn[0] = turn[1] = turn[2] = 0
  if (sine > 0) { turn[0] = angle * x / sine; turn[1] = angle * y / sine; turn[2] = angle * z / sine }
  comma = views ? ",\n" : ""
  if (form == "opensfm") {
    views = views comma sprintf("\"%s\": {\"camera\": \"c\", \"rotation\": %s, \"translation\": %s}", name, list(turn, 3, ""),
                                list(translation, 3, ""))
  } else if (form == "openmvg") {
    rows = ""
    for (i = 0; i < 3; ++i) rows = rows (i ? ", " : "") sprintf("[%.17g, %.17g, %.17g]", r[3 * i], r[3 * i + 1], r[3 * i + 2])
    views = views comma sprintf("{\"key\": %d, \"value\": {\"polymorphic_id\": 1073741824, \"ptr_wrapper\": {\"id\": %d, " \
      "\"data\": {\"local_path\": \"\", \"filename\": \"%s\", \"width\": %d, \"height\": %d, \"id_view\": %d, " \
      "\"id_intrinsic\": 0, \"id_pose\": %d}}}}", count, 2147483649 + count, name, width, height, count, count)
    poses = poses comma sprintf("{\"key\": %d, \"value\": {\"rotation\": [%s], \"center\": %s}}", count, rows, list(center, 3, ""))
  } else {
    views = views comma sprintf("{\"viewId\": \"%d\", \"poseId\": \"%d\", \"intrinsicId\": \"7\", \"path\": \"/set/%s\", " \
      "\"width\": \"%d\", \"height\": \"%d\", \"metadata\": \"\"}", count, count, name, width, height)
    poses = poses comma sprintf("{\"poseId\": \"%d\", \"pose\": {\"transform\": {\"rotation\": %s, \"center\": %s}, " \
      "\"locked\": \"0\"}}", count, list(by_columns, 9, "\""), list(center, 3, "\""))
  }
  ++count
}

# A form prints its lists by themselves, because mawk's printf takes some thousand characters.
END {
  if (form == "opensfm") {
    side = width > height ? width : height
    printf "[{\"cameras\": {\"c\": {\"projection_type\": \"brown\", \"width\": %d, \"height\": %d, \"focal_x\": %.17g, ", width,
      height, fx / side
    printf "\"focal_y\": %.17g, \"c_x\": %.17g, \"c_y\": %.17g, ", fy / side, (cx - width / 2) / side, (cy - height / 2) / side
    print "\"k1\": 0, \"k2\": 0, \"k3\": 0, \"p1\": 0, \"p2\": 0}},\n\"shots\": {\n" views "\n}, \"points\": {}}]"
  } else if (form == "openmvg") {
    print "{\"sfm_data_version\": \"0.3\", \"root_path\": \"\", \"views\": [\n" views "\n],"
    print "\"intrinsics\": [{\"key\": 0, \"value\": {\"polymorphic_id\": 2147483649, \"polymorphic_name\": \"pinhole\","
    printf "\"ptr_wrapper\": {\"id\": 2147483700, \"data\": {\"width\": %d, \"height\": %d, \"focal_length\": %.17g, ", width,
      height, fx
    printf "\"principal_point\": [%.17g, %.17g]}}}}],\n", cx, cy
    print "\"extrinsics\": [\n" poses "\n], \"structure\": [], \"control_points\": []}"
  } else {
    print "{\"version\": [\"1\", \"2\", \"1\"], \"views\": [\n" views "\n],"
    printf "\"intrinsics\": [{\"intrinsicId\": \"7\", \"width\": \"%d\", \"height\": \"%d\", \"type\": \"pinhole\", ", width, height
    printf "\"pxFocalLength\": [\"%.17g\", \"%.17g\"], \"principalPoint\": [\"%.17g\", \"%.17g\"], ", fx, fy, cx - width / 2,
      cy - height / 2
    print "\"distortionParams\": \"\"}],\n\"poses\": [\n" poses "\n]}"
  }
}
