#include "calot/view/interface/pages.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace calot::detail {
namespace {

constexpr ImGuiWindowFlags page_flags = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                        ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                        ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_AlwaysAutoResize;

/// Buttons side by side, one of them chosen. @return the one that is chosen now
template <std::size_t Count>
int choice(const Pen& pen, const char* name, int chosen, const std::array<Text, Count>& texts, float width) {
  const float gap = 0.3F * pen.m.text;
  const float each = (width - gap * static_cast<float>(Count - 1)) / static_cast<float>(Count);
  ImGui::PushID(name);
  int now = chosen;
  for (int k = 0; k < static_cast<int>(Count); ++k) {
    if (k > 0) ImGui::SameLine(0, gap);
    const ImVec2 low = ImGui::GetCursorScreenPos();
    if (ImGui::Button(pen.texts[texts[static_cast<std::size_t>(k)]].c_str(), {each, 0})) now = k;
    if (k == chosen) {  // a bar beneath it, so that the choice isn't told by shade alone
      const float bottom = low.y + ImGui::GetFrameHeight();
      ImGui::GetWindowDrawList()->AddRectFilled({low.x, bottom - 3 * pen.m.line}, {low.x + each, bottom},
                                                pen.palette.left);
    }
  }
  ImGui::PopID();
  return now;
}

bool is_mouse(const std::string& key) {
  return key.substr(0, 5) == "mouse" || key == "wheel";
}

/// One by one: "space, mouse left" is two.
std::vector<std::string> keys_of(const InterfaceControl& control) {
  std::vector<std::string> keys;
  for (std::string rest : control.keys)
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find(", "), rest.size());
      keys.push_back(rest.substr(0, end));
      rest.erase(0, std::min(end + 2, rest.size()));
    }
  return keys;
}

float keys_width(const Pen& pen, const InterfaceControl& control) {
  float width = 0;
  for (const std::string& key : keys_of(control))
    width += (is_mouse(key) ? 1.5F * pen.m.small : key_width(pen, pen.fonts.small(), key)) + 0.3F * pen.m.small;
  return width;
}

float words_height(const Pen& pen, const InterfaceControl& control, float width) {
  const std::string& words = words_of(pen, control);
  const ImFont* font = pen.fonts.small();
  const float text = font->CalcTextSizeA(font->FontSize, 1e6F, width, words.data(), words.data() + words.size()).y;
  return std::max(text + 0.35F * font->FontSize, 1.62F * font->FontSize);
}

void draw_control(const Pen& pen, const InterfaceControl& control, ImVec2 at, float keys, float width) {
  ImFont* font = pen.fonts.small();
  float x = at.x;
  for (const std::string& key : keys_of(control)) {
    if (is_mouse(key)) {
      draw_mouse(pen, {x, at.y}, 1.3F * font->FontSize, key);
      x += 1.5F * font->FontSize;
    } else {
      x += draw_key(pen, font, {x, at.y}, key);
    }
    x += 0.3F * font->FontSize;
  }
  const std::string& words = words_of(pen, control);
  pen.list->AddText(font, font->FontSize, {std::round(at.x + keys), std::round(at.y + 0.14F * font->FontSize)},
                    pen.palette.text, words.data(), words.data() + words.size(), width - keys);
}

}  // namespace

void Pages::take(InterfaceCommand command, const InterfaceState& state, InterfaceActions& actions) {
  switch (command) {
    case InterfaceCommand::pause:
      if (page_ == Page::none)
        actions.pause = true;
      else
        close(actions);
      break;
    case InterfaceCommand::restart:
      if (page_ == Page::restart) {
        close(actions);
        actions.restart = true;
      } else {
        open(Page::restart);
      }
      break;
    case InterfaceCommand::settings:
      page_ == Page::settings ? close(actions) : open(Page::settings);
      break;
    case InterfaceCommand::help:
      page_ == Page::help ? close(actions) : open(Page::help);
      break;
    case InterfaceCommand::spectator:
      actions.spectator = true;
      break;
    case InterfaceCommand::picture:
      actions.picture = true;
      break;
    case InterfaceCommand::quit:  // out of a page, then to the pause, then away
      if (page_ != Page::none)
        close(actions);
      else if (state.paused)
        actions.quit = true;
      else
        actions.pause = true;
      break;
  }
}

void Pages::close(InterfaceActions& actions) {
  if (page_ == Page::help) actions.help_closed = true;
  page_ = Page::none;
}

void Pages::draw(const Pen& pen, InterfaceActions& actions) {
  if (pen.state.paused && !was_paused_ && page_ == Page::none) opened_ = true;
  was_paused_ = pen.state.paused;
  if (page_ != Page::none || pen.state.paused)
    ImGui::GetBackgroundDrawList()->AddRectFilled({0, 0}, {pen.m.width, pen.m.height}, IM_COL32(0, 0, 0, 90));
  switch (page_) {
    case Page::settings:
      draw_settings(pen, actions);
      break;
    case Page::help:
      draw_help(pen, actions);
      break;
    case Page::restart:
      draw_question(pen, actions);
      break;
    case Page::none:
      if (pen.state.paused) draw_pause(pen, actions);
      break;
  }
  opened_ = false;
}

void Pages::begin(const Pen& pen, Text title, float width) {
  ImGui::SetNextWindowPos({0.5F * pen.m.width, 0.5F * pen.m.height}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowSizeConstraints({width, 0}, {pen.m.width, pen.m.height - pen.m.text});
  if (opened_) ImGui::SetNextWindowFocus();
  ImGui::Begin(std::string(key_of(title)).c_str(), nullptr, page_flags);
  ImGui::PushFont(pen.fonts.large());
  ImGui::TextUnformatted(pen.texts[title].c_str());
  ImGui::PopFont();
  ImGui::Dummy({0, std::round(0.15F * pen.m.text)});
}

/// A wide button with the command's key at its right end.
bool Pages::button(const Pen& pen, Text text, InterfaceCommand command, float width) {
  const ImVec2 low = ImGui::GetCursorScreenPos();
  const bool pressed = ImGui::Button(pen.texts[text].c_str(), {width, 0});
  const std::string& key = pen.state.command_keys[static_cast<std::size_t>(command)];
  if (!key.empty()) {
    Pen here = pen;
    here.list = ImGui::GetWindowDrawList();
    ImFont* font = pen.fonts.small();
    draw_key(here, font,
             {low.x + width - key_width(pen, font, key) - 0.3F * pen.m.text,
              low.y + 0.5F * (ImGui::GetFrameHeight() - 1.3F * font->FontSize)},
             key);
  }
  return pressed;
}

void Pages::draw_pause(const Pen& pen, InterfaceActions& actions) {
  const float width = 17 * pen.m.text;
  begin(pen, Text::pause_title, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_ButtonTextAlign, {0.06F, 0.5F});
  for (const InterfaceCommand command :
       {InterfaceCommand::pause, InterfaceCommand::restart, InterfaceCommand::settings, InterfaceCommand::help,
        InterfaceCommand::spectator, InterfaceCommand::picture, InterfaceCommand::quit}) {
    if (button(pen, text_of(command, pen.state), command, width)) take(command, pen.state, actions);
    if (opened_ && command == InterfaceCommand::pause) ImGui::SetItemDefaultFocus();
  }
  ImGui::PopStyleVar();
  ImGui::End();
}

void Pages::draw_question(const Pen& pen, InterfaceActions& actions) {
  const float width = 13 * pen.m.text;
  begin(pen, Text::restart_question, 0);
  ImGui::PushStyleColor(ImGuiCol_Text, pen.palette.dim);
  ImGui::TextUnformatted(pen.texts[Text::restart_recording].c_str());
  ImGui::PopStyleColor();
  ImGui::Dummy({0, std::round(0.3F * pen.m.text)});
  if (button(pen, Text::command_cancel, InterfaceCommand::quit, width)) close(actions);
  if (opened_) ImGui::SetItemDefaultFocus();
  ImGui::SameLine();
  if (button(pen, Text::command_restart, InterfaceCommand::restart, width))
    take(InterfaceCommand::restart, pen.state, actions);
  ImGui::End();
}

void Pages::draw_settings(const Pen& pen, InterfaceActions& actions) {
  const float labels = 7 * pen.m.text, width = std::min(19 * pen.m.text, pen.m.width - labels - 5 * pen.m.text);
  InterfaceSettings now = pen.state.settings;
  begin(pen, Text::settings_title, 0);
  const auto label = [&](Text text) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(pen.texts[text].c_str());
    ImGui::SameLine(labels + ImGui::GetStyle().WindowPadding.x);
    ImGui::SetNextItemWidth(width);
  };
  const auto percent = [&](Text text, double value, int low, int high, int step) {
    label(text);
    int whole = static_cast<int>(std::lround(100 * value));
    std::string format = pen.texts.filled(Text::settings_percent, {{"percent", "%d"}});
    for (std::size_t at = format.find('%'); at != std::string::npos; at = format.find('%', at + 2))
      if (format.compare(at, 2, "%d") != 0) format.insert(at, 1, '%');  // as ImGui wants it
    ImGui::SliderInt(("##" + std::string(key_of(text))).c_str(), &whole, low, high, format.c_str(),
                     ImGuiSliderFlags_AlwaysClamp);
    const int before = static_cast<int>(std::lround(100 * value));
    const double steps = static_cast<double>(whole) / step;  // a key goes to the next one, the mouse to the nearest
    const double next = ImGui::GetIO().MouseDown[0] ? std::round(steps)
                        : whole > before            ? std::ceil(steps)
                                                    : std::floor(steps);
    const int now_whole = whole == before ? before : step * static_cast<int>(next);
    return now_whole == before ? value : 0.01 * now_whole;
  };
  label(Text::settings_quality);
  now.quality = static_cast<PictureQuality>(
      choice<3>(pen, "quality", static_cast<int>(now.quality),
                {Text::settings_quality_full, Text::settings_quality_lite, Text::settings_quality_none}, width));
  now.volume = percent(Text::settings_volume, now.volume, 0, 100, 5);
  label(Text::settings_colors);
  now.colors =
      static_cast<InterfaceColors>(choice<2>(pen, "colors", static_cast<int>(now.colors),
                                             {Text::settings_colors_usual, Text::settings_colors_contrast}, width));
  now.text_scale = percent(Text::settings_text_size, now.text_scale, 75, 200, 5);
  draw_devices(pen);
  ImGui::Dummy({0, std::round(0.2F * pen.m.text)});
  if (button(pen, Text::command_close, InterfaceCommand::settings, labels + width)) close(actions);
  if (opened_) ImGui::SetItemDefaultFocus();
  ImGui::End();
  if (now != pen.state.settings) actions.settings = now;
}

void Pages::draw_devices(const Pen& pen) const {
  const float labels = 7 * pen.m.text + ImGui::GetStyle().WindowPadding.x;
  ImGui::TextUnformatted(pen.texts[Text::settings_devices].c_str());
  if (pen.state.devices.empty()) {
    ImGui::SameLine(labels);
    ImGui::TextDisabled("%s", pen.texts[Text::settings_no_devices].c_str());
  }
  bool first = true;
  for (const InterfaceDevice& device : pen.state.devices) {
    if (first)
      ImGui::SameLine(labels);
    else
      ImGui::SetCursorPosX(labels);
    first = false;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float size = 0.6F * pen.m.text;
    const ImVec2 middle(at.x + 0.5F * size, at.y + 0.5F * pen.m.text);
    if (device.connected)  // full: there; hollow: not
      ImGui::GetWindowDrawList()->AddCircleFilled(middle, 0.5F * size, pen.palette.bile, 20);
    else
      ImGui::GetWindowDrawList()->AddCircle(middle, 0.5F * size, pen.palette.caution, 20, 2 * pen.m.line);
    ImGui::SetCursorScreenPos({at.x + 1.6F * size, at.y});
    ImGui::TextUnformatted(device.name.c_str());
    ImGui::SameLine();
    ImGui::TextDisabled("%s", pen.texts[device.connected ? Text::settings_connected : Text::settings_lost].c_str());
  }
}

void Pages::draw_help(const Pen& pen, InterfaceActions& actions) {
  const float width = std::min(pen.m.width - 3.4F * pen.m.text, 64 * pen.m.text), gap = 1.5F * pen.m.text;
  const float column = 0.5F * (width - gap);
  begin(pen, Text::help_title, 0);
  const auto& controls = pen.state.controls;
  float keys = 4 * pen.m.small;
  for (const InterfaceControl& control : controls) keys = std::max(keys, keys_width(pen, control));
  keys = std::min(keys + 0.5F * pen.m.small, 0.55F * column);
  float total = 0;
  for (const InterfaceControl& control : controls) total += words_height(pen, control, column - keys);
  const float most = pen.m.height - 9.2F * pen.m.text - ImGui::GetStyle().WindowPadding.y;
  const float wanted = 0.5F * total + 2 * pen.m.small;
  ImGui::BeginChild("keys", {width, std::min(wanted, most)});
  const ImVec2 start = ImGui::GetCursorScreenPos();
  Pen here = pen;
  here.list = ImGui::GetWindowDrawList();
  float x = start.x, y = start.y, lowest = y;
  for (const InterfaceControl& control : controls) {
    if (x == start.x && y - start.y >= 0.5F * total) x += column + gap, y = start.y;
    draw_control(here, control, {x, y}, keys, column);
    y += words_height(pen, control, column - keys);
    lowest = std::max(lowest, y);
  }
  ImGui::Dummy({width - 1, lowest - start.y});
  ImGui::EndChild();
  if (ImGui::Button(pen.texts[Text::help_begin].c_str(), {12 * pen.m.text, 0})) close(actions);
  if (opened_) ImGui::SetItemDefaultFocus();
  if (const std::string& key = pen.state.command_keys[static_cast<std::size_t>(InterfaceCommand::help)]; !key.empty()) {
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    ImGui::TextDisabled("%s", pen.texts.filled(Text::help_again, {{"key", printed(key)}}).c_str());
  }
  ImGui::End();
}

}  // namespace calot::detail
