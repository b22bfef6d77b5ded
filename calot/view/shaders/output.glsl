// What a blended pass writes: light times exposure, or in LITE screen values at once.
vec3 shown(vec3 light_out) {
#ifdef LITE
  return screen_value(tone_curve(light_out * eye.w));
#else
  return min(light_out * eye.w, vec3(200.0));
#endif
}
