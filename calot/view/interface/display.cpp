#include "calot/view/interface/display.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace calot::detail {
namespace {

std::string number(double value, int digits) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

std::string clock_of(double seconds) {
  const auto whole = static_cast<long>(std::max(0.0, seconds));
  std::array<char, 48> text{};
  if (whole >= 3600)
    std::snprintf(text.data(), text.size(), "%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
  else
    std::snprintf(text.data(), text.size(), "%02ld:%02ld", whole / 60, whole % 60);
  return text.data();
}

bool has_jaws(InstrumentKind kind) {
  return kind != InstrumentKind::hook && kind != InstrumentKind::suction && kind != InstrumentKind::fan_retractor;
}

/// Faint ground beneath a block, so that words can be read over tissue where no black surrounds the field. What is
/// drawn while it lives lies above it.
class Plate {
 public:
  explicit Plate(const Pen& pen) : pen_(pen) {
    pen_.list->ChannelsSplit(2);
    pen_.list->ChannelsSetCurrent(1);
  }
  ~Plate() {
    const float over = 0.5F * pen_.m.text;
    pen_.list->ChannelsSetCurrent(0);
    if (pen_.m.radius <= 0 && low_.x < high_.x)
      pen_.list->AddRectFilled({low_.x - over, low_.y - 0.6F * over}, {high_.x + over, high_.y + 0.6F * over},
                               pen_.palette.plate, 0.3F * pen_.m.text);
    pen_.list->ChannelsMerge();
  }
  Plate(const Plate&) = delete;
  Plate& operator=(const Plate&) = delete;
  void cover(ImVec2 low, ImVec2 high) {
    low_ = {std::min(low_.x, low.x), std::min(low_.y, low.y)};
    high_ = {std::max(high_.x, high.x), std::max(high_.y, high.y)};
  }

 private:
  const Pen& pen_;
  ImVec2 low_{1e9F, 1e9F}, high_{-1e9F, -1e9F};
};

/// The words that fit into the width, taken off the text; at least one.
std::string take_line(const ImFont* font, std::string& rest, float width) {
  std::size_t end = 0;
  while (end < rest.size()) {
    const std::size_t next = std::min(rest.find(' ', end + 1), rest.size());
    if (end > 0 && Pen::width(font, rest.substr(0, next)) > width) break;
    end = next;
  }
  std::string line = rest.substr(0, end);
  rest.erase(0, std::min(rest.size(), end + 1));
  return line;
}

/// Top left: where the operation is, and what to do next. Lines follow the rim of the field.
void draw_step(const Pen& pen) {
  const Measures& m = pen.m;
  float y = m.margin;
  if (pen.state.step.empty() && pen.state.hint.empty()) return;
  Plate plate(pen);
  const auto paragraph = [&](ImFont* font, ImU32 color, std::string rest) {
    while (!rest.empty()) {
      const std::string line = take_line(font, rest, pen.free_width(y, y + font->FontSize));
      const ImVec2 at(m.margin, y);
      plate.cover(at, {at.x + Pen::width(font, line), y + font->FontSize});
      pen.text(font, at, color, line);
      y += 1.2F * font->FontSize;
    }
  };
  if (pen.state.step_number > 0)
    paragraph(pen.fonts.small(), pen.palette.dim,
              pen.texts.filled(Text::step_count, {{"number", std::to_string(pen.state.step_number)},
                                                  {"count", std::to_string(pen.state.step_count)}}));
  paragraph(pen.fonts.text(), pen.palette.text, pen.state.step);
  y += 0.25F * m.text;
  paragraph(pen.fonts.small(), pen.palette.dim, pen.state.hint);
}

using Mark = void (*)(const Pen&, ImVec2, float);

/// Top right: time, then what was lost and used.
void draw_counts(const Pen& pen) {
  const Measures& m = pen.m;
  const float right = m.width - m.margin;
  float y = 0.7F * m.margin;
  const std::string clock = clock_of(pen.state.time);
  const float clock_width = Pen::width(pen.fonts.large(), clock);
  Plate plate(pen);
  plate.cover({right - clock_width, y}, {right, y + m.large});
  pen.text(pen.fonts.large(), {right - clock_width, y}, pen.palette.text, clock);
  y += 1.25F * m.large;
  float labels = 0;
  for (const Text label : {Text::count_blood, Text::count_bile, Text::count_clips})
    labels = std::max(labels, Pen::width(pen.fonts.small(), pen.texts[label]));
  const auto row = [&](Mark mark, Text label, const std::string& value) {
    const std::string& words = pen.texts[label];
    const float value_width = std::max(Pen::width(pen.fonts.text(), value), 4.2F * m.text);
    const float label_right = right - value_width - 0.5F * m.text;
    const float left = label_right - labels - 1.5F * m.small;
    plate.cover({left, y}, {right, y + m.text});
    pen.text(pen.fonts.text(), {right - Pen::width(pen.fonts.text(), value), y}, pen.palette.text, value);
    pen.text(pen.fonts.small(), {label_right - Pen::width(pen.fonts.small(), words), y + 0.85F * (m.text - m.small)},
             pen.palette.dim, words);
    mark(pen, {left, y + 0.5F * (m.text - m.small)}, m.small);
    y += 1.35F * m.text;
  };
  const auto volume = [&](double cubic_metres) {
    const double millilitres = 1e6 * cubic_metres;
    return pen.texts.filled(Text::count_volume, {{"millilitres", number(millilitres, millilitres < 9.95 ? 1 : 0)}});
  };
  row(draw_blood, Text::count_blood, volume(pen.state.blood));
  row(draw_bile, Text::count_bile, volume(pen.state.bile));
  row(draw_clip, Text::count_clips, std::to_string(pen.state.clips));
}

std::string jaws_of(const Pen& pen, const HandState& hand) {
  if (hand.holds_clip) return pen.texts[Text::hand_holds_clip];
  if (hand.holds_tissue) return pen.texts[Text::hand_holds_tissue];
  if (!has_jaws(hand.kind)) return "";
  if (hand.opening > 0.95) return pen.texts[Text::hand_open];
  if (hand.opening < 0.05) return pen.texts[Text::hand_closed];
  return pen.texts.filled(Text::hand_half_open, {{"percent", number(std::round(20 * hand.opening) * 5, 0)}});
}

/// How hard the instrument is pushed back: a bar with a tick at the limit, and a mark and words beyond it.
void draw_force(const Pen& pen, const HandState& hand, ImVec2 at, float width, ImU32 color, bool from_right) {
  const Measures& m = pen.m;
  const float high = 0.42F * m.text, limit_share = 0.7F;
  const double most = hand.force_limit / static_cast<double>(limit_share);
  const bool too_much = hand.force > hand.force_limit;
  const std::string value = pen.texts.filled(Text::hand_force, {{"newton", number(hand.force, 1)}});
  const float value_width = std::max(Pen::width(pen.fonts.small(), value), 3.4F * m.small),
              bar = width - value_width - 0.5F * m.text;
  const float low = from_right ? at.x + width - bar : at.x;
  const float y = at.y + 0.5F * (m.small - high);
  const auto share = static_cast<float>(std::clamp(hand.force / most, 0.0, 1.0));
  const auto place = [&](float s) { return from_right ? low + bar * (1 - s) : low + bar * s; };
  pen.list->AddRectFilled({low, y}, {low + bar, y + high}, with_alpha(pen.palette.line, 0.35F), 0.5F * high);
  if (share > 0) {
    const float a = std::min(place(0), place(share)), b = std::max(place(0), place(share));
    pen.list->AddRectFilled({a, y}, {std::max(b, a + high), y + high}, too_much ? pen.palette.caution : color,
                            0.5F * high);
  }
  const float tick = place(limit_share);
  pen.list->AddRectFilled({tick - 0.5F * m.line, y - 0.25F * high}, {tick + 0.5F * m.line, y + 1.25F * high},
                          pen.palette.text);
  const float value_x = from_right ? at.x : at.x + width - Pen::width(pen.fonts.small(), value);
  pen.text(pen.fonts.small(), {value_x, at.y}, too_much ? pen.palette.caution : pen.palette.text, value);
}

constexpr float hand_height = 4.9F;  // in lines

float hand_width(const Pen& pen) {
  const float top = pen.m.height - pen.m.margin - (hand_height - 1.2F) * pen.m.text;
  return std::min(pen.free_width(top, pen.m.height), 13 * pen.m.text);
}

/// Bottom left or right: what a hand holds. The left one has a square, the right one a disc.
void draw_hand(const Pen& pen, const std::optional<HandState>& hand, bool is_right) {
  const Measures& m = pen.m;
  ImFont *usual = pen.fonts.text(), *small = pen.fonts.small();
  const ImU32 color = is_right ? pen.palette.right : pen.palette.left;
  const float block = hand_height * m.text, top = m.height - m.margin - block, width = hand_width(pen);
  const float low = is_right ? m.width - m.margin - width : m.margin;
  Plate plate(pen);
  plate.cover({low, top}, {low + width, top + block});
  const auto aligned = [&](ImFont* font, float y, ImU32 ink, const std::string& words, float before = 0) {
    pen.text(font, {is_right ? low + width - Pen::width(font, words) - before : low + before, y}, ink, words);
  };
  const float mark = 0.62F * m.small, mark_y = top + 0.5F * (m.small - mark);
  const float mark_x = is_right ? low + width - mark : low;
  if (is_right)
    pen.list->AddCircleFilled({mark_x + 0.5F * mark, mark_y + 0.5F * mark}, 0.5F * mark, color, 20);
  else
    pen.list->AddRectFilled({mark_x, mark_y}, {mark_x + mark, mark_y + mark}, color);
  aligned(small, top, pen.palette.dim, pen.texts[is_right ? Text::hand_right : Text::hand_left], 1.5F * mark);
  float y = top + 1.25F * m.small;
  if (!hand) {
    aligned(usual, y, pen.palette.dim, pen.texts[Text::hand_empty]);
    return;
  }
  aligned(usual, y, pen.palette.text, pen.texts[name_of_instrument(hand->kind)]);
  y += 1.25F * m.text;
  const bool too_much = hand->force > hand->force_limit;
  const std::string words = too_much       ? pen.texts[Text::hand_too_much]
                            : hand->energy ? pen.texts[Text::hand_energy]
                                           : jaws_of(pen, *hand);
  const float before = too_much || hand->energy ? 1.4F * m.small : 0;
  aligned(small, y, before > 0 ? pen.palette.caution : pen.palette.dim, words, before);
  const ImVec2 sign(is_right ? low + width - m.small : low, y);
  if (too_much)
    draw_caution(pen, sign, m.small);
  else if (hand->energy)
    draw_energy(pen, sign, m.small);
  y += 1.4F * m.small;
  draw_force(pen, *hand, {low, y}, width, color, is_right);
}

/// Bottom middle: what happened, the newest lowest.
void draw_messages(const Pen& pen) {
  const Measures& m = pen.m;
  constexpr double stays = 5, fades = 1.5;
  const float most = std::max(m.width - 2 * (hand_width(pen) + 2 * m.margin) - 3 * m.text, 10 * m.text);
  float bottom = m.height - m.margin;
  int shown = 0;
  for (auto message = pen.state.messages.rbegin(); message != pen.state.messages.rend() && shown < 2; ++message) {
    const auto alpha = static_cast<float>(std::clamp((stays + fades - message->age) / fades, 0.0, 1.0));
    if (alpha <= 0) continue;
    std::string rest = message->text;
    std::vector<std::string> lines;
    while (!rest.empty()) lines.push_back(take_line(pen.fonts.text(), rest, most));
    float width = 0;
    for (const std::string& line : lines) width = std::max(width, Pen::width(pen.fonts.text(), line));
    const float height = 1.2F * m.text * static_cast<float>(lines.size()), pad = 0.45F * m.text;
    const float total = width + 1.5F * m.text + 2 * pad, low = 0.5F * (m.width - total);
    pen.list->AddRectFilled({low, bottom - height - pad}, {low + total, bottom},
                            with_alpha(pen.palette.panel, 0.75F * alpha), 0.3F * m.text);
    const ImVec2 at(low + pad, bottom - height - 0.4F * pad);
    if (message->kind == MessageKind::alarm) draw_alarm(pen, at, m.text);
    if (message->kind == MessageKind::caution) draw_caution(pen, at, m.text);
    if (message->kind == MessageKind::note) draw_note(pen, at, m.text);
    for (std::size_t k = 0; k < lines.size(); ++k)
      pen.text(pen.fonts.text(), {at.x + 1.5F * m.text, at.y + 1.2F * m.text * static_cast<float>(k)},
               with_alpha(pen.palette.text, alpha), lines[k]);
    bottom -= height + 1.8F * pad;
    ++shown;
  }
}

}  // namespace

void Pen::text(ImFont* font, ImVec2 at, ImU32 color, const std::string& words) const {
  list->AddText(font, font->FontSize, {std::round(at.x), std::round(at.y)}, color, words.data(),
                words.data() + words.size());
}

float Pen::width(const ImFont* font, const std::string& words) {
  return font->CalcTextSizeA(font->FontSize, 1e6F, 0, words.data(), words.data() + words.size()).x;
}

float Pen::free_width(float top, float bottom) const {
  const float least = 9 * m.text;
  if (m.radius <= 0) return std::max(least, 0.3F * m.width);
  const float middle = 0.5F * m.height;
  const float nearest = top > middle ? top - middle : bottom < middle ? middle - bottom : 0;
  const float chord = nearest < m.radius ? std::sqrt(m.radius * m.radius - nearest * nearest) : 0;
  return std::max(least, 0.5F * m.width - chord - 1.6F * m.margin);
}

void draw_display(const Pen& pen) {
  draw_step(pen);
  draw_counts(pen);
  draw_hand(pen, pen.state.left, false);
  draw_hand(pen, pen.state.right, true);
  draw_messages(pen);
  if (!pen.state.spectator) return;
  const std::string& note = pen.texts[Text::spectator_note];
  const ImVec2 at(0.5F * (pen.m.width - Pen::width(pen.fonts.small(), note)), pen.m.margin);
  pen.list->AddRectFilled({at.x - pen.m.text, at.y - 0.3F * pen.m.text},
                          {pen.m.width - at.x + pen.m.text, at.y + 1.3F * pen.m.small}, pen.palette.plate,
                          0.3F * pen.m.text);
  pen.text(pen.fonts.small(), at, pen.palette.text, note);
}

std::vector<CommandPlace> draw_commands(const Pen& pen) {
  const Measures& m = pen.m;
  ImFont* small = pen.fonts.small();
  std::vector<CommandPlace> places;
  const float right = m.width - m.margin, row = 1.65F * small->FontSize;
  float y = 0.5F * m.height - 0.2F * row;
  Plate plate(pen);
  for (const InterfaceCommand command : {InterfaceCommand::pause, InterfaceCommand::help, InterfaceCommand::settings}) {
    const std::string& key = pen.state.command_keys[static_cast<std::size_t>(command)];
    const std::string& words = pen.texts[text_of(command, pen.state)];
    const float cap = key.empty() ? 0 : key_width(pen, small, key), width = Pen::width(small, words);
    const ImVec2 low(right - cap - 0.5F * m.text - width, y);
    plate.cover(low, {right, y + 1.3F * small->FontSize});
    pen.text(small, {low.x, y + 0.14F * small->FontSize}, pen.palette.dim, words);
    if (!key.empty()) draw_key(pen, small, {right - cap, y}, key);
    places.push_back({command, low, {right, y + row}});
    y += row;
  }
  return places;
}

const std::string& words_of(const Pen& pen, const InterfaceControl& control) {
  return pen.texts.control(control.name, control.words);
}

Text text_of(InterfaceCommand command, const InterfaceState& state) {
  switch (command) {
    case InterfaceCommand::pause:
      return state.paused ? Text::command_go_on : Text::command_pause;
    case InterfaceCommand::restart:
      return Text::command_restart;
    case InterfaceCommand::settings:
      return Text::command_settings;
    case InterfaceCommand::help:
      return Text::command_help;
    case InterfaceCommand::spectator:
      return state.spectator ? Text::command_endoscope : Text::command_spectator;
    case InterfaceCommand::picture:
      return Text::command_picture;
    case InterfaceCommand::quit:
      return Text::command_quit;
  }
  return Text::command_close;
}

}  // namespace calot::detail
