// Small pictures of the interface.
#include <array>
#include <cmath>

#include "calot/view/interface/display.h"

namespace calot::detail {
namespace {

constexpr float pi = 3.14159265F;

ImVec2 in_square(ImVec2 at, float size, float x, float y) {
  return {at.x + size * x, at.y + size * y};
}

void draw_exclamation(const Pen& pen, ImVec2 at, float size, float top, float bottom) {
  const ImU32 ink = IM_COL32(10, 10, 10, 255);
  const float half = std::max(0.055F * size, 0.6F), dot = bottom - 0.10F;
  pen.list->AddRectFilled({at.x + 0.5F * size - half, at.y + top * size},
                          {at.x + 0.5F * size + half, at.y + (dot - 0.07F) * size}, ink);
  pen.list->AddRectFilled({at.x + 0.5F * size - half, at.y + dot * size},
                          {at.x + 0.5F * size + half, at.y + bottom * size}, ink);
}

void trace_drop(const Pen& pen, ImVec2 at, float size) {
  const ImVec2 middle = in_square(at, size, 0.5F, 0.64F);
  pen.list->PathLineTo(in_square(at, size, 0.5F, 0.04F));
  pen.list->PathArcTo(middle, 0.31F * size, -0.18F * pi, 1.18F * pi, 20);
}

}  // namespace

void draw_caution(const Pen& pen, ImVec2 at, float size) {
  pen.list->AddTriangleFilled(in_square(at, size, 0.5F, 0.04F), in_square(at, size, 1, 0.94F),
                              in_square(at, size, 0, 0.94F), pen.palette.caution);
  draw_exclamation(pen, at, size, 0.36F, 0.86F);
}

void draw_alarm(const Pen& pen, ImVec2 at, float size) {
  for (int k = 0; k < 8; ++k) {
    const float angle = pi / 4 * (static_cast<float>(k) + 0.5F);
    pen.list->PathLineTo(in_square(at, size, 0.5F + 0.5F * std::cos(angle), 0.5F + 0.5F * std::sin(angle)));
  }
  pen.list->PathFillConvex(pen.palette.alarm);
  draw_exclamation(pen, at, size, 0.2F, 0.82F);
}

void draw_note(const Pen& pen, ImVec2 at, float size) {
  const ImVec2 middle = in_square(at, size, 0.5F, 0.5F);
  pen.list->AddCircle(middle, 0.44F * size, pen.palette.dim, 24, pen.m.line);
  const float half = std::max(0.05F * size, 0.5F);
  pen.list->AddRectFilled({middle.x - half, at.y + 0.42F * size}, {middle.x + half, at.y + 0.74F * size},
                          pen.palette.text);
  pen.list->AddRectFilled({middle.x - half, at.y + 0.25F * size}, {middle.x + half, at.y + 0.34F * size},
                          pen.palette.text);
}

void draw_energy(const Pen& pen, ImVec2 at, float size) {
  const ImU32 color = pen.palette.caution;
  const auto p = [&](float x, float y) { return in_square(at, size, x, y); };
  pen.list->AddTriangleFilled(p(0.62F, 0.02F), p(0.56F, 0.56F), p(0.18F, 0.56F), color);
  pen.list->AddTriangleFilled(p(0.82F, 0.42F), p(0.36F, 0.98F), p(0.44F, 0.42F), color);
}

void draw_blood(const Pen& pen, ImVec2 at, float size) {
  trace_drop(pen, at, size);
  pen.list->PathFillConvex(pen.palette.blood);
}

void draw_bile(const Pen& pen, ImVec2 at, float size) {
  trace_drop(pen, at, size);
  pen.list->PathStroke(pen.palette.bile, ImDrawFlags_Closed, std::max(1.2F, 0.13F * size));
}

void draw_clip(const Pen& pen, ImVec2 at, float size) {
  const auto p = [&](float x, float y) { return in_square(at, size, x, y); };
  pen.list->PathLineTo(p(0.95F, 0.25F));
  pen.list->PathLineTo(p(0.2F, 0.25F));
  pen.list->PathLineTo(p(0.08F, 0.5F));
  pen.list->PathLineTo(p(0.2F, 0.75F));
  pen.list->PathLineTo(p(0.95F, 0.75F));
  pen.list->PathStroke(pen.palette.text, 0, std::max(1.2F, 0.13F * size));
}

void draw_mouse(const Pen& pen, ImVec2 at, float size, const std::string& part) {
  const float half = 0.34F * size, middle = at.x + 0.5F * size, top = at.y, bottom = at.y + size;
  const float split = top + 0.42F * size, round = half;
  ImDrawList& list = *pen.list;
  const ImU32 lit = pen.palette.left, line = pen.palette.dim;
  if (part == "mouse left")
    list.AddRectFilled({middle - half, top}, {middle, split}, lit, round, ImDrawFlags_RoundCornersTopLeft);
  if (part == "mouse right")
    list.AddRectFilled({middle, top}, {middle + half, split}, lit, round, ImDrawFlags_RoundCornersTopRight);
  list.AddRect({middle - half, top}, {middle + half, bottom}, line, round, 0, pen.m.line);
  list.AddLine({middle - half, split}, {middle + half, split}, line, pen.m.line);
  list.AddLine({middle, top}, {middle, split}, line, pen.m.line);
  const bool wheel = part == "wheel" || part == "mouse middle";
  list.AddRectFilled({middle - 0.09F * size, top + 0.1F * size}, {middle + 0.09F * size, top + 0.34F * size},
                     wheel ? lit : line, 0.09F * size);
  if (part == "mouse")
    list.AddRectFilled({middle - half, split}, {middle + half, bottom}, lit, round, ImDrawFlags_RoundCornersBottom);
}

std::string printed(const std::string& name) {
  std::string cap = name;
  if (!cap.empty() && cap[0] >= 'a' && cap[0] <= 'z') cap[0] = static_cast<char>(cap[0] - 'a' + 'A');
  return cap;
}

float key_width(const Pen& pen, ImFont* font, const std::string& name) {
  return std::max(Pen::width(font, printed(name)) + 0.7F * font->FontSize, 1.35F * font->FontSize) + 2 * pen.m.line;
}

float draw_key(const Pen& pen, ImFont* font, ImVec2 at, const std::string& name) {
  const std::string cap = printed(name);
  const float width = key_width(pen, font, name), height = 1.3F * font->FontSize;
  const ImVec2 high(at.x + width, at.y + height);
  pen.list->AddRectFilled(at, high, with_alpha(pen.palette.line, 0.3F), 0.25F * font->FontSize);
  pen.list->AddRect(at, high, pen.palette.line, 0.25F * font->FontSize, 0, pen.m.line);
  pen.text(font, {at.x + 0.5F * (width - Pen::width(font, cap)), at.y + 0.14F * font->FontSize}, pen.palette.text, cap);
  return width;
}

}  // namespace calot::detail
