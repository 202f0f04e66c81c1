#version 450 core
// First pass: which face is visible at each pixel, how deep it lies, and its vertex colour.

layout(location = 0) in vec3 position;  // world
layout(location = 1) in vec3 srgb;      // the vertex's colour
layout(location = 2) in vec4 shares;    // of the zone's cells

uniform vec4 cam_from_world[3];  // rows: rotation, translation
uniform vec4 clip_from_cam;      // scale x, scale y, shift x, shift y, of x / z and y / z
uniform float near_depth;

out vec3 linear_color;
out vec4 cell_shares;

vec3 linear_from_srgb(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

void main() {
  vec4 world = vec4(position, 1.0);
  vec3 cam = vec3(dot(cam_from_world[0], world), dot(cam_from_world[1], world), dot(cam_from_world[2], world));
  // Reversed depth without a far plane: near_depth / z, which a float resolves evenly at every distance.
  gl_Position = vec4(clip_from_cam.xy * cam.xy + clip_from_cam.zw * cam.z, near_depth, cam.z);
  linear_color = linear_from_srgb(srgb);
  cell_shares = shares;
}
