// From light to what a screen shows.

// A curve like the ACES reference rendering's: fit of [Narkowicz2015].
vec3 tone_curve(vec3 x) {
  return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

// sRGB's curve.
vec3 screen_value(vec3 linear) {
  return mix(12.92 * linear, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, linear));
}

// How much of a place is seen in the round field, by its distance from the middle in radii.
float field_edge(float radius) {
  return 1.0 - smoothstep(0.972, 1.0, radius);
}
