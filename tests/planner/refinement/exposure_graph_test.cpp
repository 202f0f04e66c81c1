// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/exposure_graph.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <random>

namespace lumatlas {
namespace {

// ln gain_of_this_view - ln gain_of_slot.
ExposureRatio ratio_to(ViewSlot slot, const glm::dvec3& log_ratio, double log_luminance, std::uint32_t points = 400) {
  return {slot, log_ratio, glm::dvec3(log_luminance), points};
}
ExposureRatio grey_ratio_to(ViewSlot slot, double log_ratio, std::uint32_t points = 400) {
  return ratio_to(slot, glm::dvec3(log_ratio), log_ratio, points);
}

std::vector<double> random_logs(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 0.7);
  std::vector<double> logs(count);
  for (double& value : logs) value = normal(random);
  return logs;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// Every view measured against every one before it, as in a stream.
void measure_all_pairs(ExposureGraph& graph, const std::vector<double>& logs, std::uint32_t first = 0) {
  for (std::uint32_t i = 0; i < logs.size(); ++i) {
    std::vector<ExposureRatio> ratios;
    for (std::uint32_t j = 0; j < i; ++j) ratios.push_back(grey_ratio_to(ViewSlot(first + j), logs[i] - logs[j]));
    graph.set(ViewSlot(first + i), ratios);
  }
}

// View i against view i - 1, each ratio off by `bias`; the last one against the first closes the ring.
ExposureGraph biased_ring(std::uint32_t views, double bias, bool closed) {
  ExposureGraph graph(views);
  for (std::uint32_t i = 1; i < views; ++i) {
    std::vector<ExposureRatio> ratios{grey_ratio_to(ViewSlot(i - 1), bias)};
    if (closed && i + 1 == views) ratios.push_back(grey_ratio_to(0, 0));
    graph.set(ViewSlot(i), ratios);
  }
  return graph;
}

double log_gain(ExposureGraph& graph, ViewSlot slot) {
  return std::log(graph.solve(false)[slot].r);
}

TEST_CASE("consistent ratios between all pairs give the gains up to a common factor, with a mean logarithm of 0") {
  const std::vector<double> logs = random_logs(12, 1);
  ExposureGraph graph(12);
  measure_all_pairs(graph, logs);
  const std::vector<glm::dvec3> gains = graph.solve(false);
  double sum = 0;
  for (std::size_t i = 0; i < gains.size(); ++i) {
    CHECK(gains[i].r == gains[i].g);
    CHECK(gains[i].r == gains[i].b);
    // Pulled towards 0 by about 1e-3 of what they are.
    CHECK(std::log(gains[i].r) == Approx(logs[i] - mean(logs)).margin(2e-3));
    sum += std::log(gains[i].r);
  }
  CHECK(std::abs(sum) < 1e-6);
}

TEST_CASE("the same ratios give the same gains whichever of a pair was measured against the other") {
  ExposureGraph forward(2), backward(2);
  forward.set(1, std::vector{grey_ratio_to(0, 0.6)});
  backward.set(0, std::vector{grey_ratio_to(1, -0.6)});
  CHECK(log_gain(forward, 1) == Approx(0.3).margin(1e-3));
  CHECK(log_gain(forward, 0) == Approx(-0.3).margin(1e-3));
  for (ViewSlot slot{0}; slot < 2; ++slot) {
    CHECK(log_gain(forward, slot) == Approx(log_gain(backward, slot)).margin(1e-12));
  }
}

TEST_CASE("white balance solves each channel for itself, and without it all follow the luminance") {
  ExposureGraph graph(2);
  graph.set(1, std::vector{ratio_to(0, {0.4, -0.2, 1.0}, 0.8)});
  const std::vector<glm::dvec3> balanced = graph.solve(true);
  CHECK(std::log(balanced[1].r / balanced[0].r) == Approx(0.4).margin(1e-3));
  CHECK(std::log(balanced[1].g / balanced[0].g) == Approx(-0.2).margin(1e-3));
  CHECK(std::log(balanced[1].b / balanced[0].b) == Approx(1.0).margin(2e-3));
  const std::vector<glm::dvec3> grey = graph.solve(false);
  CHECK(grey[1].r == grey[1].b);
  CHECK(std::log(grey[1].g / grey[0].g) == Approx(0.8).margin(2e-3));
}

TEST_CASE("slots without ratios have a gain of 1, and an empty graph has none but these") {
  ExposureGraph graph(5);
  for (const glm::dvec3& gain : graph.solve(false)) CHECK(gain == glm::dvec3(1));
  graph.set(3, std::vector{grey_ratio_to(1, 0.5)});
  for (const bool white_balance : {false, true}) {
    const std::vector<glm::dvec3> gains = graph.solve(white_balance);
    for (const std::uint32_t slot : {0u, 2u, 4u}) CHECK(gains[slot] == glm::dvec3(1));
    CHECK(gains[3].r > 1.2);
  }
}

TEST_CASE("two islands of views without a ratio between them have a mean logarithm of 0 each") {
  const std::vector<double> left = random_logs(6, 2), right = random_logs(9, 3);
  ExposureGraph graph(15);
  measure_all_pairs(graph, left);
  measure_all_pairs(graph, right, 6);
  const std::vector<glm::dvec3> gains = graph.solve(false);
  double sum = 0;
  for (std::size_t i = 0; i < 6; ++i) sum += std::log(gains[i].r);
  CHECK(std::abs(sum) < 1e-6);
  for (std::size_t i = 6; i < 15; ++i) sum += std::log(gains[i].r);
  CHECK(std::abs(sum) < 1e-6);
  CHECK(std::log(gains[14].r / gains[6].r) == Approx(right[8] - right[0]).margin(4e-3));
}

TEST_CASE("a ring of 200 views with every ratio 2 % off closes where its ends were compared") {
  constexpr std::uint32_t kViews = 200;
  const double bias = std::log(1.02);
  const std::vector<glm::dvec3> closed = biased_ring(kViews, bias, true).solve(false);
  const std::vector<glm::dvec3> open = biased_ring(kViews, bias, false).solve(false);
  const double closed_gap = std::log(closed[kViews - 1].r / closed[0].r);
  const double open_gap = std::log(open[kViews - 1].r / open[0].r);
  // Matching each view to the last one would end 199 biases away, a factor of 51.
  // The closing ratio is right and bears its share of the bias, one of 200.
  CHECK(std::abs(closed_gap) < bias);
  CHECK(open_gap > 0.5);
  CHECK(open_gap < 0.25 * bias * (kViews - 1));
  for (const glm::dvec3& gain : closed) CHECK(std::abs(std::log(gain.r)) < 0.01);
}

// View i against `neighbours` earlier ones that are near to it or anywhere, each ratio off by some noise, one in twenty
// by a factor.
std::vector<ExposureRatio> noisy_ratios(std::uint32_t i, std::uint32_t neighbours, const std::vector<double>& logs,
                                        std::mt19937& random) {
  std::normal_distribution<double> noise(0, 0.03);
  std::vector<ExposureRatio> ratios;
  for (std::uint32_t k = 1; k <= std::min(i, neighbours); ++k) {
    const std::uint32_t j = k % 2 == 0 ? i - k : static_cast<std::uint32_t>(random() % i);
    const double wrong = random() % 20 == 0 ? 1.2 : 0;
    ratios.push_back(grey_ratio_to(ViewSlot(j), logs[i] - logs[j] + noise(random) + wrong,
                                   static_cast<std::uint32_t>(50 + random() % 1000)));
  }
  return ratios;
}

// Solves what ExposureGraph::solve(false) solves, by elimination. Returns ln gains.
std::vector<double> eliminated(const std::vector<std::vector<ExposureRatio>>& ratios) {
  const std::size_t n = ratios.size();
  std::vector<double> logs(n, 0);
  for (int system = 0; system < 5; ++system) {
    std::vector<std::vector<double>> A(n, std::vector<double>(n + 1, 0));
    for (std::size_t i = 0; i < n; ++i) {
      for (const ExposureRatio& ratio : ratios[i]) {
        const std::size_t j = ratio.slot;
        const double full = std::sqrt(static_cast<double>(ratio.points)), wanted = ratio.log_luminance.r;
        const double misfit = system == 0 ? 0 : (logs[i] - logs[j] - wanted) / 0.1;
        const double weight = full / (1 + misfit * misfit);
        A[i][i] += weight + 1e-3 * full;
        A[j][j] += weight + 1e-3 * full;
        A[i][j] -= weight;
        A[j][i] -= weight;
        A[i][n] += weight * wanted;
        A[j][n] -= weight * wanted;
      }
    }
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t row = k + 1; row < n; ++row) {
        const double factor = A[row][k] / A[k][k];
        for (std::size_t c = k; factor != 0 && c <= n; ++c) A[row][c] -= factor * A[k][c];
      }
    }
    for (std::size_t k = n; k-- > 0;) {
      logs[k] = A[k][n];
      for (std::size_t c = k + 1; c < n; ++c) logs[k] -= A[k][c] * logs[c];
      logs[k] /= A[k][k];
    }
  }
  return logs;
}

TEST_CASE("after every view of a stream the gains are those of an elimination") {
  constexpr std::uint32_t kViews = 60;
  const std::vector<double> logs = random_logs(kViews, 9);
  std::mt19937 random(4);
  ExposureGraph graph(kViews);
  std::vector<std::vector<ExposureRatio>> ratios;
  for (std::uint32_t i = 0; i < kViews; ++i) {
    ratios.push_back(noisy_ratios(i, 8, logs, random));
    graph.set(ViewSlot(i), ratios.back());
    const std::vector<glm::dvec3> gains = graph.solve(false);
    if (i < 2) continue;
    const std::vector<double> exact = eliminated(ratios);
    for (std::uint32_t k = 0; k <= i; ++k) REQUIRE(std::log(gains[k].r) == Approx(exact[k]).margin(1e-6));
  }
}

TEST_CASE("a view more costs some looks at all ratios, however many views there are") {
  const auto looks_a_ratio = [](std::uint32_t views) {
    const std::vector<double> logs = random_logs(views, 9);
    std::mt19937 random(4);
    ExposureGraph graph(views);
    std::size_t ratios = 0;
    for (std::uint32_t i = 0; i + 1 < views; ++i) {
      const std::vector<ExposureRatio> of_view = noisy_ratios(i, 20, logs, random);
      ratios += of_view.size();
      graph.set(ViewSlot(i), of_view);
    }
    (void)graph.solve(false);
    const std::uint64_t before = graph.looks();
    graph.set(ViewSlot(views - 1), noisy_ratios(views - 1, 20, logs, random));
    (void)graph.solve(false);
    return static_cast<double>(graph.looks() - before) / static_cast<double>(ratios);
  };
  const double few = looks_a_ratio(200), many = looks_a_ratio(800);
  CAPTURE(few, many);
  CHECK(many < 200);  // in five systems
  CHECK(many < 1.5 * few);
}

TEST_CASE("one wrong ratio of a factor of four among many does little") {
  const std::vector<double> logs = random_logs(20, 5);
  ExposureGraph graph(20);
  measure_all_pairs(graph, logs);
  std::vector<ExposureRatio> ratios;
  for (std::uint32_t j = 0; j < 19; ++j) {
    ratios.push_back(grey_ratio_to(ViewSlot(j), logs[19] - logs[j] + (j == 4 ? std::log(4.0) : 0)));
  }
  graph.set(19, ratios);
  const std::vector<glm::dvec3> gains = graph.solve(false);
  for (std::size_t i = 0; i < 20; ++i) {
    CHECK(std::log(gains[i].r) == Approx(logs[i] - mean(logs)).margin(0.01));
  }
}

TEST_CASE("ratios of many points count more than ratios of few") {
  ExposureGraph graph(2);
  graph.set(0, std::vector{grey_ratio_to(1, -0.00, 2500)});
  graph.set(1, std::vector{grey_ratio_to(0, 0.02, 25)});
  // Weights by the root of their numbers: 50 to 5.
  CHECK(log_gain(graph, 1) - log_gain(graph, 0) == Approx(0.02 / 11).margin(2e-4));
}

TEST_CASE("new ratios of a view take the place of its old ones") {
  ExposureGraph graph(3);
  graph.set(2, std::vector{grey_ratio_to(0, 3.0)});
  graph.set(2, std::vector{grey_ratio_to(1, 0.2)});
  CHECK(graph.solve(false)[0] == glm::dvec3(1));
  CHECK(log_gain(graph, 2) - log_gain(graph, 1) == Approx(0.2).margin(1e-3));
}

TEST_CASE("an erased slot leaves nothing behind, neither its own ratios nor those to it") {
  const std::vector<double> logs = random_logs(8, 6);
  ExposureGraph graph(9);
  measure_all_pairs(graph, logs);
  const std::vector<glm::dvec3> before = graph.solve(false);
  std::vector<ExposureRatio> wrong;
  for (std::uint32_t j = 0; j < 8; ++j) wrong.push_back(grey_ratio_to(ViewSlot(j), 0.3 * j));
  graph.set(8, wrong);
  graph.set(0, std::vector{grey_ratio_to(8, 2.0)});
  CHECK(graph.solve(false) != before);
  graph.erase(8);
  const auto is_as_before = [&](const std::vector<glm::dvec3>& gains) {
    for (std::size_t i = 0; i < gains.size(); ++i) CHECK(gains[i].r == Approx(before[i].r).epsilon(1e-6));
  };
  const std::vector<glm::dvec3> after = graph.solve(false);
  CHECK(after[8] == glm::dvec3(1));
  is_as_before(after);
  graph.erase(8);
  is_as_before(graph.solve(false));
}

TEST_CASE("gains stay finite and positive for ratios as far off as ratios can be") {
  ExposureGraph graph(3);
  graph.set(1, std::vector{grey_ratio_to(0, 9.2)});
  graph.set(2, std::vector{grey_ratio_to(0, -9.2), grey_ratio_to(1, 9.2)});
  for (const glm::dvec3& gain : graph.solve(false)) {
    CHECK(std::isfinite(gain.r));
    CHECK(gain.r > 0);
  }
}

}  // namespace
}  // namespace lumatlas
