// Light on a surface: the endoscope's lamp, and what the cavity gives back.
uniform sampler2DShadow shadow_map;

const float pi = 3.14159265;

// GGX [Walter2007] times the height-correlated Smith term in the approximation of [Hammon2017].
float specular_term(float alpha, float n_h, float n_l, float n_v) {
  float a2 = alpha * alpha;
  float d = (n_h * a2 - n_h) * n_h + 1.0;
  float visible = 0.5 / max(mix(2.0 * n_l * n_v, n_l + n_v, alpha), 1e-4);
  return a2 / (pi * d * d) * visible;
}

// Schlick's fifth power [Schlick1994].
float schlick(float v_h) {
  float m = 1.0 - v_h;
  float m2 = m * m;
  return m2 * m2 * m;
}

// Share of the lamp that reaches a point: percentage-closer filter [Reeves1987].
float lamp_visibility(vec3 position, vec3 normal, float distance) {
  vec4 place = light_view_projection * vec4(position + normal * distance * ambient.w * 1.5, 1.0);
  vec3 at = place.xyz / place.w * 0.5 + 0.5;
#ifdef LITE
  return texture(shadow_map, at);
#else
  float sum = 0.0;
  float radius = 1.7 * ambient.w;
  sum += texture(shadow_map, at + radius * vec3(-0.33, -0.94, 0.0));
  sum += texture(shadow_map, at + radius * vec3(0.94, -0.33, 0.0));
  sum += texture(shadow_map, at + radius * vec3(0.33, 0.94, 0.0));
  sum += texture(shadow_map, at + radius * vec3(-0.94, 0.33, 0.0));
  return 0.25 * sum;
#endif
}

// The lamp's light by direction: bright in the middle of the field, less towards its edge.
float lamp_cone(float cosine) {
  float edge = clamp((cosine - 0.60) / 0.40, 0.0, 1.0);
  return 0.12 + 0.88 * edge * edge * (3.0 - 2.0 * edge);
}

// What a mirror sees that looks along `ray`: lit tissue ahead, little behind the camera.
vec3 cavity(vec3 ray) {
  float ahead = dot(ray, forward.xyz);
  return ambient.rgb * (0.15 + 4.5 * smoothstep(-0.35, 0.95, ahead));
}

vec3 shade(Material m, vec3 n, vec3 position, vec3 smooth_normal, float open) {
  vec3 to_eye = eye.xyz - position;
  vec3 v = normalize(to_eye);
  vec3 to_light = light.xyz - position;
  float d2 = dot(to_light, to_light);
  float distance = sqrt(d2);
  vec3 l = to_light / distance;
  vec3 h = normalize(l + v);
  float n_l_raw = dot(n, l);
  float n_l = max(n_l_raw, 0.0);
  float n_v = max(dot(n, v), 0.05);
  float n_h = max(dot(n, h), 0.0);
  float v_h = max(dot(v, h), 0.0);
  float lamp = light.w / d2 * lamp_cone(dot(-l, light_axis.xyz)) * lamp_visibility(position, smooth_normal, distance);
  open *= m.ao;

  // Wrapped diffuse light that gives back no more than it gets [McGuire2010]; wider in red, so that edges glow.
  vec3 wrap = m.subsurface;
  vec3 wrapped = max(vec3(0.0), (n_l_raw + wrap) / ((1.0 + wrap) * (1.0 + wrap)));
  float widening = 0.0015 / distance;  // the lamp's end is about 3 mm wide [Karis2013]
  float rough = clamp(m.roughness * m.roughness + widening, 0.003, 1.0);
  vec3 f0 = mix(vec3(0.028), m.base, m.metal);
  float fresnel = schlick(v_h);
  vec3 f = f0 + (1.0 - f0) * fresnel;
  vec3 diffuse = m.base * (1.0 - m.metal) * (1.0 - f) * wrapped / pi;
  vec3 direct = diffuse + f * specular_term(rough, n_h, n_l, n_v) * n_l;

  float grazing = schlick(n_v);
  vec3 bounced = ambient.rgb * open;
  vec3 indirect = m.base * (1.0 - m.metal) * bounced;
  vec3 mirrored = cavity(reflect(-v, n)) * open;
  indirect += mirrored * (f0 + (max(vec3(1.0 - m.roughness), f0) - f0) * grazing) * (1.0 - 0.6 * m.roughness);

  // The wet film lies over all of it.
  float film = m.coat * (0.025 + 0.975 * fresnel);
  float film_rough = clamp(m.coat_roughness * m.coat_roughness + widening, 0.003, 1.0);
  vec3 color = (direct * lamp * pi + indirect) * (1.0 - film);
  color += film * specular_term(film_rough, n_h, n_l, n_v) * n_l * lamp * pi;
  color += mirrored * m.coat * (0.025 + (1.0 - m.coat_roughness) * 0.975 * grazing) * 0.6;
  return color;
}
