// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/report/report.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"
#include "tools/base/html_text.h"
#include "tools/score/report/json_fields.h"

namespace lumatlas {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Over the mesh's pixels scores are higher by 3 dB.
RegionScores region(double psnr, std::size_t pixels, double textured) {
  RegionScores made;
  made.pixels = std::isnan(psnr) ? 0 : pixels;
  made.raw = {psnr - 1, 0.5};
  made.fitted = {psnr, 0.625};
  made.gain = 1.25;
  made.textured = textured;
  return made;
}

ReportRendering rendering(double psnr, const std::string& name) {
  ReportRendering made;
  made.scores.frame = region(psnr, 200, 0.5);
  made.scores.mesh = region(psnr + 3, 100, 0.75);
  made.picture = "renderings/" + name + ".png";
  made.error = "errors/" + name + ".png";
  return made;
}

ReportView view(const std::string& name, double store_psnr, double vertex_psnr) {
  ReportView made;
  made.name = name;
  made.photograph = "photographs/" + name + ".jpg";
  made.width = 640;
  made.height = 480;
  made.renderings = {rendering(store_psnr, name + "-store"), rendering(vertex_psnr, name + "-vertex")};
  return made;
}

Report small_report() {
  Report report;
  report.title = "office";
  report.input_views = 21;
  report.methods = {{"store", "the view store"}, {"vertex", "averaged colours"}};
  report.views = {view("a", 25, 20), view("b", 22, 21), view("c", 28, 18)};
  return report;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) {
    ++found;
  }
  return found;
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_CASE("the page shows every view's three pictures for every method") {
  const std::string page = report_page(small_report());
  for (const std::string name : {"a", "b", "c"}) {
    CHECK(count(page, "src=\"photographs/" + name + ".jpg\"") == 2);
    for (const std::string method : {"store", "vertex"}) {
      CHECK(count(page, "src=\"renderings/" + name + "-" + method + ".png\"") == 1);
      CHECK(count(page, "src=\"errors/" + name + "-" + method + ".png\"") == 1);
    }
  }
  CHECK(count(page, "<article") == 3);
  CHECK(count(page, "</article>") == 3);
}

TEST_CASE("the views come worst first by the first method, those without a score last") {
  Report report = small_report();
  report.views.insert(report.views.begin(), view("unseen", kNaN, kNaN));
  report.views.push_back(view("identical", kInfinity, 19));
  const std::string page = report_page(report);
  std::size_t last = 0;
  for (const std::string name : {"b", "a", "c", "identical", "unseen"}) {
    const std::size_t at = page.find("data-name=\"" + name + "\"");
    CAPTURE(name);
    REQUIRE(at != std::string::npos);
    CHECK(at > last);
    last = at;
  }
}

TEST_CASE("the summary shows the means and marks the best of each column") {
  const std::string page = report_page(small_report());
  CHECK(holds(page, "<tr><th>store</th><th>frame</th><td class=\"best\">24.00</td>"));
  CHECK(holds(page, "<td class=\"best\">25.00</td>"));
  CHECK(holds(page, "<tr><th>vertex</th><th>frame</th><td>18.67</td>"));
  CHECK(holds(page, "<tr><th>store</th><th>mesh</th><td class=\"best\">27.00</td>"));
  CHECK(page.find("<th>store</th><th>frame</th>") < page.find("<th>store</th><th>mesh</th>"));
  CHECK(holds(page, "<td class=\"best\">50.0 %"));
  CHECK(holds(page, "<td class=\"best\">75.0 %"));
  CHECK_FALSE(holds(page, "aligned</th>"));
}

TEST_CASE("aligned scores appear once every view has them") {
  Report report = small_report();
  for (ReportView& view : report.views) {
    for (ReportRendering& rendering : view.renderings) {
      rendering.scores.frame.aligned = Scores{33.3, 0.9};
      rendering.scores.frame.aligned_pixels = 200;
      rendering.scores.mesh.aligned = Scores{36.6, 0.95};
      rendering.scores.mesh.aligned_pixels = 100;
    }
  }
  const std::string page = report_page(report);
  CHECK(holds(page, "aligned</th>"));
  CHECK(holds(page, "33.30"));
  CHECK(holds(page, "36.60"));
  const nlohmann::json store = report_json(report)["methods"]["store"];
  CHECK(store["frame"]["aligned"]["psnr"].get<double>() == Approx(33.3));
  CHECK(store["aligned"]["psnr"].get<double>() == Approx(36.6));
}

TEST_CASE("seams and flicker appear where they were measured, on the page and in the JSON") {
  Report report = small_report();
  CHECK(!holds(report_page(report), "seams"));
  report.methods[0].seams = 3.14159;
  report.methods[1].seams = std::numeric_limits<double>::quiet_NaN();
  CHECK(holds(report_page(report), "<td>3.14</td>"));
  CHECK(!holds(report_page(report), "flicker"));
  report.methods[0].flicker = Flicker{1.25, 7.5, 1000};
  CHECK(holds(report_page(report), "<td>1.25</td><td>7.50</td>"));
  const nlohmann::json json = report_json(report);
  CHECK(json["methods"]["store"]["seams"] == 3.14159);
  CHECK(json["methods"]["store"]["flicker"] == nlohmann::json({{"rms", 1.25}, {"worst", 7.5}, {"followed", 1000}}));
  CHECK(json["methods"]["vertex"]["seams"].is_null());
  CHECK(!json["methods"]["vertex"].contains("flicker"));
}

TEST_CASE("what the store lacks is told apart into budget and refined poses, each with its sign in words") {
  Report report = small_report();
  const auto told = [&](double moved, double budget) {
    report.shortfall = ReportShortfall{moved, budget};
    const std::string sentence = shortfall_sentence(report);
    CHECK(holds(report_page(report), "<p>" + sentence + "</p>") == !sentence.empty());
    return sentence;
  };
  CHECK(shortfall_sentence(report).empty());
  CHECK(told(0, -0.3).empty());
  CHECK(told(0.2, -0.3).empty());
  const std::string below = "The store is 0.70 dB (fitted) below the unbounded baseline: ";
  const std::string given = " dB, for those of the photographs left out stay as they were given.";
  CHECK(told(0, 0.7) == below + "the budget costs all of it, refined poses nothing.");
  CHECK(told(0.2, 0.5) == below + "the budget costs 0.50 dB, refined poses cost 0.20" + given);
  CHECK(told(-0.2, 0.9) == below + "the budget costs 0.90 dB, refined poses gain 0.20 dB.");
  CHECK(told(0.9, -0.2) == below + "the budget gains 0.20 dB, refined poses cost 0.90" + given);
}

TEST_CASE("each protocol is told in a sentence") {
  Report report = small_report();
  CHECK(holds(
      report_page(report),
      "Of every 8 photographs by name one was held out, so its neighbours are known: 3 views are scored, 21 other "
      "photographs could be learned from."));
  report.protocol = HoldOut{5, 40};
  CHECK(holds(report_page(report), "Whole runs of 40 photographs were held out, one run of every 5"));
  report.protocol.reset();
  report.test = "a<b";
  CHECK(holds(report_page(report), "The views of a&lt;b, none of them in the scene: 3 views are scored, 21 other"));
  CHECK(report_json(report)["protocol"] == nlohmann::json{{"test", "a<b"}});
}

TEST_CASE("the page needs no network") {
  const std::string page = report_page(small_report());
  for (const std::string part : {"http:", "https:", "//cdn", "@import", "<link rel=\"stylesheet", "<script src"}) {
    CHECK_FALSE(holds(page, part));
  }
}

TEST_CASE("names cannot break out of the page, nor paths out of their attributes") {
  Report report = small_report();
  const std::string evil = "<script>alert('1')</script>&\"";
  report.title = evil;
  report.methods[0] = {evil, evil};
  report.views[0].name = evil;
  report.facts = {{evil, evil}};
  report.views[0].photograph = "a b/\"><script>alert(1)</script>#?%.jpg";
  report.views[0].renderings[0].picture = "javascript:alert(1)";
  const std::string page = report_page(report);
  CHECK_FALSE(holds(page, "<script>alert"));
  CHECK(holds(page, "&lt;script&gt;alert(&#39;1&#39;)&lt;/script&gt;&amp;&quot;"));
  CHECK(holds(page, "src=\"a%20b/%22%3E%3Cscript%3Ealert%281%29%3C/script%3E%23%3F%25.jpg\""));
  CHECK_FALSE(holds(page, "javascript:"));
}

TEST_CASE("a URL keeps folders and plain names and encodes every byte of others") {
  CHECK(url_of("../photographs/DSC_01.JPG") == "../photographs/DSC_01.JPG");
  CHECK(url_of("f\xc3\xbc\xc3\x9f.png") == "f%C3%BC%C3%9F.png");
  CHECK(html_escaped("plain") == "plain");
}

TEST_CASE("a report without views, with equal scores or with pictures missing is a page all the same") {
  Report report = small_report();
  report.views.clear();
  CHECK(holds(report_page(report), "0 views are scored"));
  report.views = {view("a", 20, 20), view("b", 20, 20)};
  report.views[0].renderings[0].picture.clear();
  CHECK(holds(report_page(report), "no picture"));
  report.views = {view("far", -400, 1e6)};
  CHECK(holds(report_page(report), "1000000.00"));
}

TEST_CASE("a report that contradicts itself is refused by name") {
  CHECK_THROWS_WITH(report_page(Report{}), "report: the number of methods is 0, must be at least 1");
  Report report = small_report();
  report.views[1].renderings.pop_back();
  CHECK_THROWS_WITH(report_page(report), "report: the number of renderings of view b is 1, must be 2, one per method");
  report = small_report();
  report.views[2].photograph = "/home/somebody/c.jpg";
  CHECK_THROWS_WITH(report_json(report),
                    "report: a picture of view c is /home/somebody/c.jpg, must be a path relative to the page");
  report = small_report();
  report.views[0].width = 0;
  CHECK_THROWS_WITH(report_page(report), "report: the size of view a is 0x480, must be at least 1x1");
}

TEST_CASE("the report is written as a whole") {
  const TemporaryFolder folder;
  write_report(folder / "report.html", small_report());
  CHECK(bytes_of(folder / "report.html") == report_page(small_report()));
  CHECK_THROWS_AS(write_report(folder / "missing" / "report.html", small_report()), InputError);
}

TEST_CASE("the JSON has the keys that scripts rely on") {
  const nlohmann::json json = report_json(small_report());
  CHECK(json["protocol"] == nlohmann::json{{"hold", 8}, {"block", 1}});
  CHECK(json["held"] == 3);
  const nlohmann::json& store = json["methods"]["store"];
  CHECK(store["frame"]["raw"]["psnr"].get<double>() == Approx(24));
  CHECK(store["frame"]["fitted"]["psnr"].get<double>() == Approx(25));
  CHECK(store["frame"]["textured"].get<double>() == Approx(0.5));
  CHECK(store["raw"]["psnr"].get<double>() == Approx(27));
  CHECK(store["fitted"]["psnr"].get<double>() == Approx(28));
  CHECK(store["fitted"]["ssim"].get<double>() == Approx(0.625));
  CHECK(store["textured"].get<double>() == Approx(0.75));
  CHECK_FALSE(store.contains("aligned"));
  CHECK(json["views"][1]["name"] == "b");
  CHECK(json["views"][1]["methods"]["vertex"]["frame"]["fitted"]["psnr"].get<double>() == Approx(21));
  CHECK(json["views"][1]["methods"]["vertex"]["gain"].get<double>() == Approx(1.25));
  CHECK(json["views"][1]["methods"]["vertex"]["pixels"] == 100);
  CHECK(json["views"][1]["methods"]["vertex"]["frame"]["pixels"] == 200);
}

TEST_CASE("JSON has a large number for identical pictures and null for nothing to score") {
  CHECK(json_scores(Scores{kInfinity, 1})["psnr"] == kPsnrOfIdentical);
  CHECK(json_scores(Scores{kNaN, kNaN})["psnr"].is_null());
  CHECK(json_scores(Scores{kNaN, kNaN})["ssim"].is_null());
  CHECK(json_number(kInfinity).is_null());
  CHECK(json_number(-2.5) == -2.5);
}

}  // namespace
}  // namespace lumatlas
