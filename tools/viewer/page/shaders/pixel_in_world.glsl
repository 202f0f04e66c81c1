// Returns the point of the surface that a pixel shows; `at` is like gl_FragCoord.
vec3 world_of(vec2 at, float z) {
  vec3 cam = vec3((vec2(at.x, center.w - at.y) - intrinsics.zw) / intrinsics.xy, 1.0) * z;
  return center.xyz + cam.x * cam_from_world[0].xyz + cam.y * cam_from_world[1].xyz + cam.z * cam_from_world[2].xyz;
}
