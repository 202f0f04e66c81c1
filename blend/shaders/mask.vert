#version 300 es
// Parts of a page of photographs whose validities are written.

layout(location = 0) in vec2 place;  // of a corner, texels in the page
layout(location = 1) in vec3 mask;   // texels, and which of the masks

uniform vec2 size;  // of what is drawn into, texels

out vec2 texel;
flat out int number;

void main() {
  gl_Position = vec4(2.0 * place / size - 1.0, 0.0, 1.0);
  texel = mask.xy;
  number = int(mask.z);
}
