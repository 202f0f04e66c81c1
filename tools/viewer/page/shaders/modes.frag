#version 300 es
// Draws the views and weights of a picture in colours.
precision highp float;
precision highp int;
precision highp usampler2D;

#include "../../../../blend/shaders/picture.glsl"
#include "../../../../blend/shaders/surface_texel.glsl"
#include "../../../../blend/shaders/srgb.glsl"

uniform usampler2D surfaces;
uniform usampler2D diagnosis;  // the output of diagnose.frag: valid views, winner, shares of the three best
uniform int mode;              // 0: averaged colours, 1: geometry, 2: winner, 3: weights, 4: coverage

layout(location = 0) out vec4 color;

vec3 cam_at(ivec2 pixel) {
  uvec4 texel = texelFetch(surfaces, clamp(pixel, ivec2(0), textureSize(surfaces, 0) - 1), 0);
  if (texel.x == kNothing) return vec3(0.0);
  vec2 image = vec2(float(pixel.x) + 0.5, center.w - float(pixel.y) - 0.5);
  return vec3((image - intrinsics.zw) / intrinsics.xy, 1.0) * uintBitsToFloat(texel.y);
}

// Light from the camera.
vec3 shaded(ivec2 pixel) {
  vec3 here = cam_at(pixel);
  vec3 across = cam_at(pixel + ivec2(1, 0)) - here;
  vec3 down = cam_at(pixel + ivec2(0, 1)) - here;
  vec3 normal = cross(across, down);
  float facing = length(normal) > 0.0 ? abs(dot(normalize(normal), normalize(here))) : 1.0;
  return vec3(0.12 + 0.8 * facing);
}

// Neighbouring numbers far apart on the circle of hues.
vec3 color_of(uint number) {
  float hue = fract(float(number) * 0.61803398875);
  float light = 0.65 + 0.35 * fract(float(number) * 0.41421356);
  return light * clamp(abs(fract(hue + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, 0.15, 1.0);
}

vec3 shown(ivec2 pixel, Surface surface) {
  if (mode == 0) return srgb_from_linear(exposure.rgb * surface.fallback);
  if (mode == 1) return shaded(pixel);
  uvec4 texel = texelFetch(diagnosis, pixel, 0);
  vec3 none = vec3(0.25);
  if (texel.x == 0u) return none;
  if (mode == 2) return color_of(texel.y);
  if (mode == 3) return vec3(unpackUnorm2x16(texel.z), unpackUnorm2x16(texel.w).x);
  // Few views red, many green.
  float share = clamp(float(texel.x) / 8.0, 0.0, 1.0);
  return mix(mix(vec3(0.75, 0.15, 0.15), vec3(0.9, 0.8, 0.2), min(2.0 * share, 1.0)), vec3(0.15, 0.65, 0.3),
             max(2.0 * share - 1.0, 0.0));
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uvec4 texel = texelFetch(surfaces, pixel, 0);
  color = texel.x == kNothing ? vec4(0.0) : vec4(shown(pixel, surface_of(texel)), 1.0);
}
