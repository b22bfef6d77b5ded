// The cavity's wall where a scene has none: peritoneum with fat behind it, far enough to be dim and without detail.
uniform sampler3D tissue_noise;

Material cavity_wall(vec3 place, vec3 n) {
  vec3 at = mat3(0.7071, 0.5417, -0.4545, -0.6428, 0.7660, -0.0870, 0.2947, 0.3463, 0.8906) * place;
  vec4 large = texture(tissue_noise, at * 5.0), medium = texture(tissue_noise, at * 17.0 + 0.3);
  float fatty = smoothstep(0.42, 0.66, 0.75 * large.b + 0.25 * medium.b);
  Material m;
  vec3 flesh = vec3(0.46, 0.165, 0.125) * (0.72 + 0.55 * medium.b), fat = vec3(0.66, 0.43, 0.20) * (0.85 + 0.2 * medium.g);
  m.base = mix(flesh, fat, fatty);
  m.roughness = 0.6;
  m.coat = 0.35;
  m.coat_roughness = 0.38;
  m.subsurface = vec3(0.35, 0.15, 0.10);
  m.height = 0.0025 * large.b + fatty * 0.0010 * medium.g;
  m.metal = 0.0;
  m.ao = mix(1.0, 0.82 + 0.18 * medium.g, fatty);
  return m;
}
