// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/waiting.h"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

std::vector<WaitingView> views_with_news(const std::vector<double>& news) {
  std::vector<WaitingView> views(news.size());
  for (std::size_t i = 0; i < news.size(); ++i) {
    views[i].camera = room_camera(i);
    views[i].news = news[i];
  }
  return views;
}

TEST_CASE("the view with the least news is given up first") {
  CHECK(least_useful(views_with_news({0.9, 0.3, 0.8})) == 1);
  CHECK(least_useful(views_with_news({0.1})) == 0);
}

TEST_CASE("of views with as much news the one that is most like another is given up, the later of the two") {
  std::vector<WaitingView> views = views_with_news({1, 1, 1, 1, 1});
  views[3].camera = room_camera(1);
  CHECK(least_useful(views) == 3);
  views[1].news = 0.5;  // less, though it is like another
  CHECK(least_useful(views) == 1);
}

TEST_CASE("the depth frame that is most like another is given up") {
  std::vector<WaitingDepth> frames;
  for (const std::size_t number : {0U, 5U, 9U, 5U, 12U}) frames.push_back({"", room_camera(number), {}});
  CHECK(most_alike(frames) == 3);
  frames.resize(1);
  CHECK(most_alike(frames) == 0);
}

}  // namespace
}  // namespace lumatlas
