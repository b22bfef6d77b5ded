// The cavity's wall where a scene has none: peritoneum over muscle and fat, far enough to be dim.
float lattice(vec3 p) {
  p = fract(p * vec3(0.1031, 0.1030, 0.0973));
  p += dot(p, p.yzx + 33.33);
  return fract((p.x + p.y) * p.z);
}

float smooth_noise(vec3 p) {
  vec3 i = floor(p), f = fract(p);
  f = f * f * (3.0 - 2.0 * f);
  vec2 s = vec2(0.0, 1.0);
  vec4 a = vec4(lattice(i), lattice(i + s.yxx), lattice(i + s.xyx), lattice(i + s.yyx));
  vec4 b = vec4(lattice(i + s.xxy), lattice(i + s.yxy), lattice(i + s.xyy), lattice(i + s.yyy));
  vec4 c = mix(a, b, f.z);
  vec2 d = mix(c.xz, c.yw, f.x);
  return mix(d.x, d.y, f.y);
}

Material cavity_wall(vec3 place, vec3 n) {
  float large = smooth_noise(place * 28.0), medium = smooth_noise(place * 90.0 + 7.0);
  Material m;
  vec3 flesh = vec3(0.52, 0.20, 0.16), fat = vec3(0.66, 0.44, 0.22);
  m.base = mix(flesh, fat, smoothstep(0.45, 0.75, 0.65 * large + 0.35 * medium)) * (0.75 + 0.4 * medium);
  m.roughness = 0.55;
  m.coat = 0.5;
  m.coat_roughness = 0.35;
  m.subsurface = vec3(0.35, 0.15, 0.10);
  m.height = 0.004 * large + 0.0012 * medium;
  m.metal = 0.0;
  m.ao = 0.6 + 0.4 * medium;
  return m;
}
