#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/testing/folder.h"
#include "report/testing/page_with_player.h"

namespace keypose::report::player_section_test {

using ::testing::HasSubstr;

/// The page's document after a moment in a headless browser; empty if there is no Chromium.
std::string Browsed(const std::string& page, const std::string& more) {
  const TestingFolder own;
  const std::filesystem::path folder = own.path();
  std::ofstream(folder / "index.html") << page;
  const std::string command =
      "HOME=" + folder.string() +
      " timeout 100 chromium --headless --no-sandbox --use-angle=swiftshader " + more +
      " --enable-unsafe-swiftshader --disable-background-networking --virtual-time-budget=3000 "
      "--dump-dom file://" +
      (folder / "index.html").string() + " > " + (folder / "dom").string() + " 2> " +
      (folder / "log").string();
  const int code = std::system(command.c_str());
  std::ostringstream dom;
  dom << std::ifstream(folder / "dom").rdbuf();
  return code == 0 ? dom.str() : "";
}

bool HasChromium() { return std::system("command -v chromium > /dev/null 2>&1") == 0; }

TEST(Player, PlaysInABrowserWithoutAnyServer) {
  if (!HasChromium()) GTEST_SKIP() << "chromium is not installed";
  const std::string dom = Browsed(PageWithPlayer(), "");
  EXPECT_THAT(dom, HasSubstr("data-state=\"live\""));
  EXPECT_THAT(dom, HasSubstr("<canvas"));
  EXPECT_THAT(dom, HasSubstr("picture "));  // the clock has been written
  EXPECT_THAT(dom, HasSubstr("Pause"));     // it started by itself
}

TEST(Player, ItsPosterIsPrintedInPlaceOfTheCanvas) {
  if (!HasChromium()) GTEST_SKIP() << "chromium is not installed";
  const TestingFolder folder;
  const std::string pdf = (folder.path() / "page.pdf").string();
  Browsed(PageWithPlayer(), "--print-to-pdf=" + pdf);
  std::ostringstream printed;
  printed << std::ifstream(pdf).rdbuf();
  // The poster is the only picture of one pixel.
  EXPECT_THAT(printed.str(), HasSubstr("/Subtype /Image\n/Width 1\n/Height 1\n"));
}

TEST(Player, ShowsThePosterWithoutWebGl) {
  if (!HasChromium()) GTEST_SKIP() << "chromium is not installed";
  const std::string dom = Browsed(PageWithPlayer(), "--disable-gpu --disable-3d-apis");
  EXPECT_THAT(dom, HasSubstr("data-state=\"poster\""));
  EXPECT_EQ(dom.find("<canvas"), std::string::npos);
  EXPECT_THAT(dom, HasSubstr("alt=\"poster\""));
}

}  // namespace keypose::report::player_section_test
