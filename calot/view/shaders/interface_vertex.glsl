// The interface: triangles in pixels from the top left corner.
layout(location = 0) in vec2 in_place;
layout(location = 1) in vec2 in_letter;
layout(location = 2) in vec4 in_color;
uniform vec2 picture_size;
out vec2 letter;
out vec4 color_here;

void main() {
  letter = in_letter;
  color_here = in_color;
  gl_Position = vec4(2.0 * in_place.x / picture_size.x - 1.0, 1.0 - 2.0 * in_place.y / picture_size.y, 0.0, 1.0);
}
