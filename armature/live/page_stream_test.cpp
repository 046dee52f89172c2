#include "armature/live/page_stream.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "armature/live/posed_puppet.h"
#include "armature/live/puppet_files.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"

namespace keypose::armature::page_stream_test {

TEST(PageStream, ASlideIsShownInMillimetresOnlyIfTheDescriptionHasAUnit) {
  for (const std::string units : {"units cm ", ""}) {
    const TestingFolder folder;
    PuppetPaths paths;
    paths.description = folder.Put(
        "d.txt", units +
                     "node { name lift slide 0 0 1 sensor 0 node { name hip node { name upper "
                     "length 1 node { name knee axis 1 0 0 sensor 1 node { name lower length 1 } "
                     "} } } }");
    paths.chains = folder.Put("c.txt",
                              "anchor a physical hip computer hip anchor b physical lower computer "
                              "lower chain leg from a to b");
    const LoadedPuppet puppet = LoadPuppet(paths, {});
    PageStream page(puppet.parts, PlateFiles({}, {}, puppet.parts.mesh.points), true,
                    folder.path() / "page");
    PosedPuppet posed(puppet.parts);
    PageLine line;
    line.values = {0.12, 0};
    posed.Update(line.values);
    const auto shown = nlohmann::json::parse(page.Line(posed.matcher(), line));
    const auto view = nlohmann::json::parse(ReadFile(folder.path() / "page/view.json"));
    EXPECT_EQ(shown["values"][0], units.empty() ? 0.12 : 120);
    EXPECT_EQ(view["sensors"][0]["unit"], units.empty() ? "" : "mm");
  }
}

}  // namespace keypose::armature::page_stream_test
