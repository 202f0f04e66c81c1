// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/waiting.h"

#include <catch2/catch.hpp>
#include <chrono>
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

TEST_CASE("views that are not decided wait up to the bound of all, and decided ones up to theirs") {
  std::vector<WaitingView> views = views_with_news({0.9, 0.3, 0.8, 0.6, 0.1});
  CHECK_FALSE(one_too_many(views, 5, 5));
  CHECK(one_too_many(views, 4, 5) == 4);
  CHECK(one_too_many(views, 5, 4) == 4);
  views[4].for_depths = 7;
  CHECK_FALSE(one_too_many(views, 5, 4));
  CHECK(one_too_many(views, 5, 3) == 1);
  CHECK(one_too_many(views, 4, 3) == 4);
}

TEST_CASE("a view that has been ready for the longest wait comes before any that is new") {
  using std::chrono::milliseconds;
  std::vector<WaitingView> views = views_with_news({0.2, 0.9});
  const LiveClock::time_point now = LiveClock::now();
  const milliseconds longest(1000);
  for (WaitingView& view : views) view.ready = now;
  CHECK(urgency(views[0], now, longest) < urgency(views[1], now, longest));
  views[0].ready = now - milliseconds(600);
  CHECK(urgency(views[0], now, longest) < urgency(views[1], now, longest));
  views[0].ready = now - milliseconds(800);
  CHECK(urgency(views[0], now, longest) > urgency(views[1], now, longest));
}

TEST_CASE("as many views may wait as are stored within the longest wait, without the time for new poses") {
  using std::chrono::milliseconds;
  const milliseconds longest(1000);
  LiveClock::time_point now = LiveClock::now();
  StoringPace pace;
  ViewsWork work;
  WaitingView view;
  CHECK(pace.most_decided(longest) > 1'000'000);
  view.ready = now;
  now += milliseconds(50);
  pace.note_stored(view, now, work);
  CHECK(pace.most_decided(longest) == 20);
  CHECK(pace.most_decided(milliseconds(60)) == 4);  // however long they take
  now += milliseconds(15'050);
  work.moves += 15'000;  // a loop closure
  pace.note_stored(view, now, work);
  CHECK(pace.most_decided(longest) == 20);
  view.ready = now + milliseconds(3000);  // in the middle of another loop closure
  view.work_before = work;
  view.work_before.moves += 2000;
  work.moves += 7000;
  now = view.ready + milliseconds(5050);
  pace.note_stored(view, now, work);
  CHECK(pace.most_decided(longest) == 20);
  for (int stored = 0; stored < 50; ++stored) {
    now += milliseconds(125);
    pace.note_stored(view, now, work);
  }
  CHECK(pace.most_decided(longest) == 8);
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
