#version 450 core
// Draws the visible face of each pixel, and its depth. The image's first row is its top.

layout(location = 0) in vec3 position;     // world
layout(location = 1) in uint first_index;  // the run of faces that is drawn, three indices a face

uniform vec3 center;             // the camera's in the world
uniform mat3 cam_from_world;     // rotation
uniform vec4 clip_from_cam;      // scale x, scale y, shift x, shift y, of x / z and y / z
uniform float near_depth;

flat out uint first_face;

void main() {
  // The difference first: close to the camera it is exact, however far from the origin both are.
  vec3 cam = cam_from_world * (position - center);
  // Reversed depth without a far plane: near_depth / z, which a float resolves evenly at every distance.
  gl_Position = vec4(clip_from_cam.xy * cam.xy + clip_from_cam.zw * cam.z, near_depth, cam.z);
  first_face = first_index / 3u;
}
