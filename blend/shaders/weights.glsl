// The weight of a stored view at a point of the surface, and its share in the colour. Erat et al. 2019, section 3.1,
// and Buehler et al. 2001; see blend_options.h.

// `o` is the distance of the picture's camera.
float geometric_weight(vec3 to_novel, float o, vec3 to_stored) {
  float i = length(to_stored);
  if (!(o > 0.0 && i > 0.0)) return 0.0;
  // The sum of what each cosine lacks to 1 is exact where it is small: 1 minus the cosine is half the square of the
  // distance between the two directions' unit vectors.
  vec3 apart = to_novel / o - to_stored / i;
  float lacks_dir = min(1.0, 0.5 * dot(apart, apart));
  float lacks_pos = departures.x != 0 ? min(1.0, o / i) : abs(o - i) / max(o, i);
  return 1.0 - (weights.x * lacks_dir + (1.0 - weights.x) * lacks_pos);
}

// Returns the factor of the weight at a rim of the surface that the stored view sees.
float rim_share(vec3 to_novel, float o, vec3 to_stored) {
  float i = length(to_stored);
  if (departures.y == 0 || !(o > 0.0 && i > 0.0)) return 0.0;
  return smoothstep(RIM_FAR_COSINE, RIM_NEAR_COSINE, dot(to_novel, to_stored) / (o * i));
}

// The weight of a view where the share `left` of it is left: see blend/geometric_weight.h. Never more than `weight`.
float faded_weight(float weight, float left) {
  if (!(left < 1.0)) return weight;
  if (!(left > 0.0)) return 0.0;
  float penalty = (1.0 - weight + FADE_PENALTY * (1.0 - left)) / left;
  return max(1.0 - penalty, LEAST_FADED * left * weight);
}

// Returns the share of one of several cells, up to a factor that all have in common: divided by what its best view lacks.
float share_of_cell(float share, float winner) {
  if (!(winner > 0.0)) return 0.0;
  return departures.w != 0 ? share / max(1.0 - winner, LEAST_PENALTY) : share;
}

// Returns the share of a view with this weight in a pixel, up to a factor that all views have in common. `next_weight`
// is that of the best view that is left out, `winner` that of the best.
float share_of(float weight, float next_weight, float winner) {
  if (!(weight > 0.0)) return 0.0;
  float above = weight - (departures.z != 0 ? next_weight : 0.0);
  float even = min(EVEN, EVEN_SLOPE * (1.0 - winner));
  return departures.w != 0 ? above / max(1.0 - weight + even, LEAST_PENALTY) : above;
}
