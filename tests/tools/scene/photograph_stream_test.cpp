// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/photograph_stream.h"

#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

// Views of photographs of one grey each, 10 times the view's index.
std::vector<SceneView> grey_views(const TemporaryFolder& folder, std::uint8_t count) {
  std::vector<SceneView> views(count);
  for (std::uint8_t i = 0; i < count; ++i) {
    Photograph photograph{4, 3, std::vector<std::uint8_t>(4 * 3 * 3, static_cast<std::uint8_t>(10 * i)), {}};
    views[i].image = folder / (std::to_string(i) + ".png");
    write_image(views[i].image, photograph);
    views[i].lens.width = views[i].camera.width = 4;
    views[i].lens.height = views[i].camera.height = 3;
    views[i].lens.parameters = {4, 4, 2, 1.5};
    views[i].camera.fx = views[i].camera.fy = 4;
    views[i].camera.cx = 2;
    views[i].camera.cy = 1.5;
  }
  return views;
}

TEST_CASE("photographs come in the order of the ranks, and then no more") {
  const TemporaryFolder folder;
  const std::vector<SceneView> views = grey_views(folder, 6);
  PhotographStream photographs(views, {5, 0, 3, 3});
  for (const int grey : {50, 0, 30, 30}) CHECK(photographs.next().rgb.front() == grey);
  CHECK_THROWS_AS(photographs.next(), std::logic_error);
}

TEST_CASE("a rank that is no index into the views is refused before anything is read") {
  const TemporaryFolder folder;
  const std::vector<SceneView> views = grey_views(folder, 2);
  CHECK_THROWS_WITH(PhotographStream(views, {0, 2}), Catch::Contains("a rank is 2") && Catch::Contains("views, 2"));
}

TEST_CASE("a photograph that cannot be read is reported when it is its turn") {
  const TemporaryFolder folder;
  const std::vector<SceneView> views = grey_views(folder, 3);
  std::filesystem::remove(views[1].image);
  PhotographStream photographs(views, {0, 1, 2});
  CHECK_NOTHROW(photographs.next());
  CHECK_THROWS_AS(photographs.next(), InputError);
  CHECK(photographs.next().rgb.front() == 20);
}

}  // namespace
}  // namespace lumatlas
