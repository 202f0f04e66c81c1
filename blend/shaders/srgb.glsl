// Returns what srgb_from_linear() of atlas/images/srgb.h does, with light clamped to [0, 1].
vec3 srgb_from_linear(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
}

// Returns linear_from_srgb() within 0.05 of 255 levels, without powers, which software takes long for.
vec3 near_linear_from_srgb(vec3 c) {
  vec3 power = ((((0.0786288 * c - 0.285408) * c + 0.647806) * c + 0.526396) * c + 0.0317755) * c + 0.000955218;
  return mix(c / 12.92, power, greaterThan(c, vec3(0.04045)));
}

vec3 linear_from_srgb(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}
