// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/color_bar.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "tools/picture/bitmap_font.h"

namespace lumatlas {

namespace {

constexpr Rgb8 kBackground = {22, 22, 24};
constexpr Rgb8 kText = {235, 235, 235};

// Lengths in dots. A dot is a square of 2 pixels or more, larger on larger pictures.
constexpr std::uint32_t kMargin = 5;
constexpr std::uint32_t kBarHeight = 9;
constexpr std::uint32_t kTick = 3;        // length of its line
constexpr std::uint32_t kLeastBar = 140;  // width
constexpr std::uint32_t kMostBar = 420;   // width
constexpr std::uint32_t kLine = 12;       // from one line of names to the next
constexpr std::uint32_t kSwatch = 8;      // its side
constexpr std::uint32_t kBetweenNames = 8;
constexpr std::uint32_t kLabelRoom = 36;  // that a number on the bar takes with the space around it

void fill(Photograph& picture, std::uint32_t left, std::uint32_t top, std::uint32_t width, std::uint32_t height,
          const Rgb8& color) {
  for (std::uint32_t y = top; y < std::min(top + height, picture.height); ++y) {
    for (std::uint32_t x = left; x < std::min(left + width, picture.width); ++x) {
      std::copy(color.begin(), color.end(),
                picture.rgb.begin() + static_cast<std::ptrdiff_t>(3 * (std::size_t{y} * picture.width + x)));
    }
  }
}

std::string label(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), std::abs(value) < 1e6 && value == std::round(value) ? "%.0f" : "%.4g", value);
  return text.data();
}

// Round numbers, and the largest of all: what lies on it is what people look for.
std::vector<double> labelled(const ColorScale& scale, std::size_t count) {
  std::vector<double> numbers = round_numbers(scale.least, scale.most, count, scale.whole);
  const double room = (scale.most - scale.least) / static_cast<double>(count);
  while (!numbers.empty() && numbers.back() > scale.most - room) numbers.pop_back();
  numbers.push_back(scale.most);
  return numbers;
}

// The position of a named colour, in lines as wide as the picture.
struct NamePosition {
  std::uint32_t left, line;
};
std::uint32_t name_width(const NamedColor& named, std::uint32_t scale) {
  return (kSwatch + 4) * scale + text_width(named.name, scale);
}

std::vector<NamePosition> name_positions(const std::vector<NamedColor>& names, std::uint32_t width,
                                         std::uint32_t scale) {
  std::vector<NamePosition> places;
  std::uint32_t left = kMargin * scale;
  std::uint32_t line = 0;
  for (const NamedColor& named : names) {
    const std::uint32_t wide = name_width(named, scale);
    if (left > kMargin * scale && left + wide + kMargin * scale > width) {
      left = kMargin * scale;
      ++line;
    }
    places.push_back({left, line});
    left += wide + kBetweenNames * scale;
  }
  return places;
}

std::uint32_t least_width(const ColorBar& bar, std::uint32_t scale) {
  std::uint32_t width = text_width(bar.title, scale);
  if (bar.scale) width = std::max(width, kLeastBar * scale);
  for (const NamedColor& named : bar.names) width = std::max(width, name_width(named, scale));
  return width + 2 * kMargin * scale;
}

void draw_scale(Photograph& canvas, const ColorScale& scale, std::uint32_t top, std::uint32_t dot) {
  const std::uint32_t left = kMargin * dot;
  const std::uint32_t width = std::min(canvas.width - 2 * left, kMostBar * dot);
  for (std::uint32_t x = 0; x < width; ++x) {
    fill(canvas, left + x, top, 1, kBarHeight * dot, scale.color((x + 0.5) / width));
  }
  const std::uint32_t label_top = top + (kBarHeight + kTick + 1) * dot;
  const std::size_t count = std::max<std::size_t>(2, width / (kLabelRoom * dot) + 1);
  for (const double value : labelled(scale, count)) {
    const double part = (value - scale.least) / (scale.most - scale.least);
    const auto x = left + static_cast<std::uint32_t>(std::lround(part * (width - dot)));
    fill(canvas, x, top + kBarHeight * dot, dot, kTick * dot, kText);
    const std::string text = label(value) + (scale.open && value >= scale.most ? "+" : "");
    const std::uint32_t wide = text_width(text, dot);
    const std::uint32_t most_left = canvas.width - std::min(canvas.width, wide + dot);
    const std::uint32_t text_left = std::min(x + dot / 2 > wide / 2 ? x + dot / 2 - wide / 2 : 0, most_left);
    draw_text(canvas, std::max(text_left, dot), label_top, text, dot, kText);
  }
}

void draw_names(Photograph& canvas, const std::vector<NamedColor>& names, std::uint32_t top, std::uint32_t dot) {
  const std::vector<NamePosition> places = name_positions(names, canvas.width, dot);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::uint32_t y = top + places[i].line * kLine * dot;
    // A rim, so that a swatch of the background's colour is seen.
    fill(canvas, places[i].left, y, kSwatch * dot, kSwatch * dot, kText);
    fill(canvas, places[i].left + dot, y + dot, (kSwatch - 2) * dot, (kSwatch - 2) * dot, names[i].color);
    draw_text(canvas, places[i].left + (kSwatch + 3) * dot, y, names[i].name, dot, kText);
  }
}

void require_scale(const ColorScale& scale) {
  if (std::isfinite(scale.least) && std::isfinite(scale.most) && scale.least < scale.most) return;
  throw std::invalid_argument("colour bar: its scale goes from " + label(scale.least) + " to " + label(scale.most) +
                              ", must be finite and ascending");
}

}  // namespace

std::vector<double> round_numbers(double least, double most, std::size_t count, bool whole) {
  constexpr double kSlack = 1e-9;  // share of a step: 0.3 / 0.1 is less than 3
  const auto inside = [&](double step) {
    return std::floor(most / step + kSlack) - std::ceil(least / step - kSlack) + 1;
  };
  double power = std::pow(10, std::floor(std::log10((most - least) / static_cast<double>(count))));
  if (whole) power = std::max(power, 1.0);
  double step = power;
  for (int i = 0; inside(step) > static_cast<double>(count); ++i) {
    step = power * std::pow(10, i / 3) * std::array{1.0, 2.0, 5.0}[static_cast<std::size_t>(i % 3)];
  }
  std::vector<double> numbers;
  const double first = std::ceil(least / step - kSlack);
  for (double i = 0; i < inside(step); ++i) numbers.push_back((first + i) * step);
  return numbers;
}

Photograph with_color_bar(const Photograph& picture, const ColorBar& bar) {
  if (bar.scale) require_scale(*bar.scale);
  const std::uint32_t dot = std::max(2u, (std::min(picture.width, picture.height) + 135) / 270);
  Photograph canvas;
  canvas.width = std::max(picture.width, least_width(bar, dot));
  std::uint32_t below = 2 * kMargin + kGlyphHeight;
  const std::uint32_t scale_top = below - kMargin + 3;
  if (bar.scale) below = scale_top + kBarHeight + kTick + 1 + kGlyphHeight + kMargin;
  const std::uint32_t names_top = below;
  if (!bar.names.empty()) below += (name_positions(bar.names, canvas.width, dot).back().line + 1) * kLine + kMargin;
  canvas.height = picture.height + below * dot;
  canvas.rgb.resize(std::size_t{3} * canvas.width * canvas.height);
  fill(canvas, 0, 0, canvas.width, canvas.height, kBackground);
  for (std::size_t y = 0; y < picture.height; ++y) {
    std::copy_n(&picture.rgb[3 * y * picture.width], std::size_t{3} * picture.width, &canvas.rgb[3 * y * canvas.width]);
  }
  draw_text(canvas, std::int64_t{kMargin} * dot, picture.height + std::int64_t{kMargin} * dot, bar.title, dot, kText);
  if (bar.scale) draw_scale(canvas, *bar.scale, picture.height + scale_top * dot, dot);
  draw_names(canvas, bar.names, picture.height + names_top * dot, dot);
  return canvas;
}

}  // namespace lumatlas
