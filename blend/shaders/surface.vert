#version 300 es
// First pass: the visible surface at each pixel.

#include "picture.glsl"

layout(location = 0) in vec3 position;  // world
layout(location = 1) in vec3 srgb;      // the vertex's colour
layout(location = 2) in vec3 shares;    // of the zone's first three cells
layout(location = 3) in uint zone;      // the same at all corners of a face

out vec3 linear_color;
out vec3 cell_shares;
flat out uint zone_of_face;

vec3 linear_from_srgb(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

void main() {
  vec4 world = vec4(position, 1.0);
  vec3 cam = vec3(dot(cam_from_world[0], world), dot(cam_from_world[1], world), dot(cam_from_world[2], world));
  // Clipped where z is below the nearest depth. What is in front is decided by gl_FragDepth.
  gl_Position = vec4(clip_from_cam.xy * cam.xy + clip_from_cam.zw * cam.z, 2.0 * exposure.w - cam.z, cam.z);
  linear_color = linear_from_srgb(srgb);
  cell_shares = shares;
  zone_of_face = zone;
}
