#version 300 es
// First pass: the visible surface at each pixel.

#include "picture.glsl"
#include "srgb.glsl"

layout(location = 0) in vec3 position;  // world
layout(location = 1) in vec3 srgb;      // the vertex's colour
layout(location = 2) in vec3 shares;    // shares of the zone's first three cells
layout(location = 3) in uint zone;      // the same at all corners of a face

uniform uint first_zone;  // the number of the mesh's first zone, where several meshes share the tables

out vec3 linear_color;
out vec3 cell_shares;
flat out uint zone_of_face;

void main() {
  vec4 world = vec4(position, 1.0);
  vec3 cam = vec3(dot(cam_from_world[0], world), dot(cam_from_world[1], world), dot(cam_from_world[2], world));
  // Clipped where z is below the nearest depth. Depth is reversed and without a far plane, nearest / z, which a float
  // resolves evenly at every distance. Without clip control, by which the position says so, gl_FragDepth does.
#ifdef CLIP_CONTROL
  float clip_z = exposure.w;
#else
  float clip_z = 2.0 * exposure.w - cam.z;
#endif
  gl_Position = vec4(clip_from_cam.xy * cam.xy + clip_from_cam.zw * cam.z, clip_z, cam.z);
  linear_color = linear_from_srgb(srgb);
  cell_shares = shares;
  zone_of_face = first_zone + zone;
}
