#version 300 es
// A picture on the canvas, enlarged where it is smaller. Where there is no surface, the colours around it go on, or there
// is a background.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

#include "../../../../blend/shaders/srgb.glsl"
#include "surroundings.glsl"

uniform sampler2D image;  // sRGB; alpha 0: no surface
uniform vec4 place;       // of the picture, pixels: left, bottom, width, height
uniform vec3 above, below;
uniform bool continues;
uniform usampler2D fine;    // of the surroundings: the finest cells, filled; the first row is the top
uniform vec2 cells_across;  // and down, of the picture

const float WHOLE = 0.9999;  // share of a surface beside which nothing else shows

layout(location = 0) out vec4 color;

void main() {
  ivec2 size = textureSize(image, 0);
  vec2 share = (gl_FragCoord.xy - place.xy) / place.zw;
  vec2 at = share * vec2(size) - 0.5;
  vec2 first = floor(at);
  vec2 f = at - first;
  vec4 sum = vec4(0.0);
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = ivec2(i & 1, i >> 1);
    vec2 part = mix(1.0 - f, f, vec2(corner));
    vec4 texel = texelFetch(image, clamp(ivec2(first) + corner, ivec2(0), size - 1), 0);
    if (texel.a > 0.0) sum += part.x * part.y * vec4(texel.rgb, 1.0);
  }
  vec4 around = continues ? between(fine, vec2(share.x, 1.0 - share.y) * cells_across) : vec4(-1.0);
  float surface = sum.a * clamp(around.a, 0.0, 1.0);
  if (around.a < 0.0) surface = sum.a;
  vec3 shown = sum.rgb;
  // A loop, because renderers in software run both sides of a branch.
  for (bool is_open = surface < WHOLE; is_open; is_open = false) {
    // Two levels of noise, so that what changes slowly has no bands.
    float noise = (fract(sin(dot(gl_FragCoord.xy, vec2(12.9898, 78.233))) * 43758.5453) - 0.5) / 128.0;
    if (around.a < 0.0) {
      shown = sum.rgb + (1.0 - sum.a) * (mix(below, above, smoothstep(0.0, 1.0, share.y)) + noise);
    } else {
      vec3 mixed = mix(around.rgb, linear_from_srgb(sum.rgb / max(sum.a, 1e-6)), surface);
      shown = srgb_from_linear(mixed) + (1.0 - surface) * noise;
    }
  }
  color = vec4(shown, 1.0);
}
