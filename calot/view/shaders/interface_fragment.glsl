// Letters and plain shapes: how much of a pixel they cover is in the font's texture, red.
uniform sampler2D color_map;
in vec2 letter;
in vec4 color_here;
out vec4 color;

void main() {
  color = vec4(color_here.rgb, color_here.a * texture(color_map, letter).r);
}
