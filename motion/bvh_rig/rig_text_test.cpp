#include "motion/bvh_rig/rig_text.h"

#include <gtest/gtest.h>

#include <string>

#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "motion/bvh_rig/rigged_mesh.h"

namespace keypose::motion::rig_text_test {

TEST(MakeRig, ReadsGraphsAndMatrices) {
  const Mesh box = MakeBox(1, 1, 1);
  std::string weights = "2 8\n";
  for (int i = 0; i < 8; ++i) weights += i % 2 ? "1\n" : "0.5\n";
  for (int i = 0; i < 8; ++i) weights += i % 2 ? "0\n" : "0.5\n";
  const std::string skeleton = "1 0 0 0\n2 0 0 1\n3 0 0 2\n#\n2 3\n1 2\n#\n";
  const RiggedMesh rig = MakeRig(box, skeleton, "a.tgf", weights, "a.dmat");
  ASSERT_EQ(rig.bones.size(), 2u);
  EXPECT_EQ(rig.bones[0].name, "1-2");
  EXPECT_EQ(rig.bones[1].parent, 0);
  EXPECT_EQ(rig.weights[1], (std::vector<std::pair<int, double>>{{rig.Find("2-3"), 1.0}}));
  EXPECT_EQ(rig.weights[0].size(), 2u);
  EXPECT_THROW(MakeRig(box, skeleton, "a.tgf", "3 8\n", "a.dmat"), InputError);
  EXPECT_THROW(MakeRig(box, skeleton, "a.tgf", "2 8\n1 1 1\n", "a.dmat"), InputError);
  EXPECT_THROW(MakeRig(box, "1 0 0 0\n#\n1 9\n", "a.tgf", weights, "a.dmat"), InputError);
}

TEST(MakeRig, ReadsMakeHumansFiles) {
  const Mesh box = MakeBox(1, 1, 1);
  const std::string skeleton =
      R"({"bones": {"hand": {"head": "b", "tail": "c", "parent": "arm"},
                    "arm": {"head": "a", "tail": "b", "parent": null}},
          "joints": {"a": [0], "b": [0, 1], "c": [2]}})";
  const RiggedMesh rig =
      MakeRig(box, skeleton, "a.mhskel", R"({"weights": {"hand": [[3, 2.0]]}})", "a.mhw");
  EXPECT_EQ(rig.bones[0].name, "arm");
  EXPECT_EQ(rig.bones[1].head, 0.5 * (box.points.row(0) + box.points.row(1)).transpose());
  EXPECT_EQ(rig.weights[3], (std::vector<std::pair<int, double>>{{1, 1.0}}));
  const auto fails = [&](const std::string& s, const std::string& w) {
    EXPECT_THROW(MakeRig(box, s, "a.mhskel", w, "a.mhw"), InputError) << s << w;
  };
  fails(skeleton, R"({"weights": {"paw": [[3, 1]]}})");
  fails(skeleton, R"({"weights": {"hand": [[8, 1]]}})");
  fails(R"({"bones": {"a": {"head": "a", "tail": "a", "parent": "b"}}, "joints": {"a": [0]}})",
        R"({"weights": {}})");
  fails(R"({"bones": {"a": {"head": "x", "tail": "a"}}, "joints": {"a": [0]}})",
        R"({"weights": {}})");
  fails("{", "{");
}

}  // namespace keypose::motion::rig_text_test
