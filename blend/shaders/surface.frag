#version 450 core

in vec3 linear_color;

layout(location = 0) out uint face;
layout(location = 1) out float depth;   // z in the camera frame
layout(location = 2) out vec4 fallback;  // linear

void main() {
  face = uint(gl_PrimitiveID);
  depth = 1.0 / gl_FragCoord.w;
  fallback = vec4(linear_color, 1.0);
}
