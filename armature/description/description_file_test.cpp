#include "armature/description/description_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "armature/testing/theropods.h"
#include "core/values/angles.h"
#include "core/values/errors.h"

namespace keypose::armature::description_file_test {

using ::testing::HasSubstr;

// The excerpt of the paper, with its line breaks and comments.
const char* const kLeg = R"(node {
name rightKneeBend
# joint name
axis
1 0 0
# joint axis
sensor 5
# sensor index
scale 25
# gear ratio
node {
name
rightCalve
# rod name
length 4
# rod length
node {
name rightAnkleSwivel
axis 0 0 1
sensor 6
scale -10
node {
name rightAnkleBend
axis
1 0 0
sensor 7
scale 25
}
}
}
}
)";

Armature Parse(const std::string& text) {
  return DescriptionFile::Parse(text, "leg.txt").armature();
}

std::string Fault(const std::string& text) {
  try {
    DescriptionFile::Parse(text, "leg.txt");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

std::string Joint(const std::string& more) {
  return "node { name a axis 1 0 0 sensor 0 " + more + " }";
}

TEST(DescriptionFile, ReadsThePapersLeg) {
  const Armature leg = Parse(kLeg);
  ASSERT_EQ(leg.nodes.size(), 4u);
  EXPECT_EQ(leg.nodes[0].name, "rightKneeBend");
  EXPECT_EQ(leg.nodes[0].kind, NodeKind::kJoint);
  EXPECT_EQ(leg.nodes[0].sensor, 5);
  EXPECT_EQ(leg.nodes[0].scale, 25);
  EXPECT_EQ(leg.nodes[1].kind, NodeKind::kRod);
  EXPECT_EQ(leg.nodes[1].length, 4);
  EXPECT_EQ(leg.nodes[1].axis, Eigen::Vector3d::UnitY());
  EXPECT_EQ(leg.nodes[2].axis, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(leg.nodes[2].scale, -10);
  EXPECT_EQ(leg.nodes[3].parent, 2);
  EXPECT_EQ(leg.nodes[3].line, 22);
  EXPECT_EQ(leg.joints, (std::vector<int>{0, 2, 3}));
  EXPECT_EQ(leg.JointOfSensor(6), 1);
  EXPECT_EQ(leg.sensor_count(), 8);
  EXPECT_EQ(leg.metres_per_unit, 0);
}

TEST(DescriptionFile, IsWrittenBackToTheByte) {
  for (const std::string& text :
       {std::string(kLeg), std::string("#\r\n  units mm#x\n") + kLeg + " \t# the end",
        std::string("node{name a node{name b length 1}}")})
    EXPECT_EQ(DescriptionFile::Parse(text, "leg.txt").Text(), text);
}

TEST(DescriptionFile, IsUtf8WithOrWithoutAByteOrderMark) {
  const std::string text =
      "\xEF\xBB\xBFnode { name H\xC3\xBC"
      "fte }";
  EXPECT_EQ(Parse(text).nodes[0].name,
            "H\xC3\xBC"
            "fte");
  EXPECT_EQ(DescriptionFile::Parse(text, "leg.txt").Text(), text);
  EXPECT_THAT(Fault("node { name H\xFC"
                    "fte }"),
              HasSubstr("leg.txt:1:13: "));
  EXPECT_THAT(Fault("node { name H\xFC"
                    "fte }"),
              HasSubstr("is not written in UTF-8"));
  Parse(
      "# H\xFC"
      "fte, in a comment\nnode { name hips }");
}

TEST(DescriptionFile, ScaleCanBeTakenByThePapersWord) {
  const Armature inverse =
      Parse("scale_is joint_per_encoder node { name a axis 1 0 0 sensor 0 scale -0.04 }");
  EXPECT_DOUBLE_EQ(inverse.nodes[0].scale, -25);
}

TEST(DescriptionFile, UnitsTurnLengthsAndSlidesIntoMetres) {
  const Armature rig = Parse(
      "units mm counts 4096 rodaxis 0 0 -2\n"
      "node { name a slide 0 0 1 sensor 0 scale 0.2 node { name b length 40 } "
      "node { name c length 3 rodaxis 1 0 0 } }");
  EXPECT_DOUBLE_EQ(rig.nodes[0].scale, 200);
  EXPECT_DOUBLE_EQ(rig.nodes[1].length, 0.04);
  EXPECT_EQ(rig.nodes[1].axis, Eigen::Vector3d(0, 0, -1));
  EXPECT_EQ(rig.nodes[2].axis, Eigen::Vector3d::UnitX());
  EXPECT_EQ(rig.counts_per_revolution, 4096);
}

TEST(DescriptionFile, LimitsAreDegreesAndOfSlidesTheUnit) {
  const Armature rig = Parse(
      "units cm node { name a slide 0 0 1 sensor 0 limits -2 5.5 "
      "node { name b axis 1 0 0 sensor 1 limits -150 0 } node { name c axis 1 0 0 sensor 2 } }");
  EXPECT_DOUBLE_EQ(rig.nodes[0].low, -0.02);
  EXPECT_DOUBLE_EQ(rig.nodes[0].high, 0.055);
  EXPECT_DOUBLE_EQ(rig.nodes[1].low, -150 * kDegree);
  EXPECT_EQ(rig.nodes[1].high, 0);
  EXPECT_TRUE(std::isinf(rig.nodes[2].low) && std::isinf(rig.nodes[2].high));
  const Armature again = Parse(DescriptionText(rig));
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_NEAR(again.nodes[n].low, rig.nodes[n].low, 1e-14);
    EXPECT_NEAR(again.nodes[n].high, rig.nodes[n].high, 1e-14);
  }
  EXPECT_TRUE(std::isinf(again.nodes[2].low));
}

TEST(DescriptionFile, ChangedScaleChangesNothingElse) {
  DescriptionFile file = DescriptionFile::Parse(kLeg, "leg.txt");
  file.SetScale(2, -10.05);
  std::string expected = kLeg;
  expected.replace(expected.find("scale -10") + 6, 3, "-10.05");
  EXPECT_EQ(file.Text(), expected);
  EXPECT_EQ(Parse(file.Text()).nodes[2].scale, -10.05);
}

TEST(DescriptionFile, MissingScaleIsAddedBehindTheSensor) {
  DescriptionFile file = DescriptionFile::Parse(
      "scale_is joint_per_encoder\nnode {name a axis 1 0 0 sensor 0# x\n node{scale 2 axis 1 0 0 "
      "sensor 1 name b}}",
      "leg.txt");
  file.SetScale(0, 4);
  file.SetScale(1, 8);
  EXPECT_EQ(file.Text(),
            "scale_is joint_per_encoder\nnode {name a axis 1 0 0 sensor 0 scale 0.25# x\n "
            "node{scale 0.125 axis 1 0 0 sensor 1 name b}}");
}

TEST(DescriptionText, IsReadAgainAsTheSameArmature) {
  const Armature made = MakeTheropod();
  const Armature read = Parse(DescriptionText(made));
  ASSERT_EQ(read.nodes.size(), made.nodes.size());
  EXPECT_EQ(read.joints, made.joints);
  for (std::size_t n = 0; n < made.nodes.size(); ++n) {
    EXPECT_EQ(read.nodes[n].name, made.nodes[n].name);
    EXPECT_EQ(read.nodes[n].parent, made.nodes[n].parent);
    EXPECT_EQ(read.nodes[n].kind, made.nodes[n].kind);
    EXPECT_EQ(read.nodes[n].axis, made.nodes[n].axis);
    EXPECT_EQ(read.nodes[n].sensor, made.nodes[n].sensor);
    EXPECT_NEAR(read.nodes[n].scale, made.nodes[n].scale, 1e-12 * 200);
    EXPECT_NEAR(read.nodes[n].length, made.nodes[n].length, 1e-15);
  }
}

TEST(DescriptionFile, FaultsNameLineAndColumn) {
  EXPECT_EQ(Fault("node {\n  nam a\n}"),
            "leg.txt:2:3: 'nam' is not known here; did you mean 'name'? (known: name, axis, slide, "
            "sensor, scale, length, rodaxis, limits, node)");
  EXPECT_EQ(
      Fault("node {\n  name ü axi 1\n}"),
      "leg.txt:2:10: 'axi' is not known here; did you mean 'axis'? (known: name, axis, slide, "
      "sensor, scale, length, rodaxis, limits, node)");
  EXPECT_THAT(Fault("unit mm"), HasSubstr("leg.txt:1:1: 'unit' is not known here; did you mean "
                                          "'units'?"));
  EXPECT_THAT(Fault("units feet node { name a }"), HasSubstr("leg.txt:1:7: 'feet'"));
  EXPECT_THAT(Fault(Joint("scale x")), HasSubstr("scale must be a number, not 'x'"));
  EXPECT_THAT(Fault(Joint("scale 0")), HasSubstr("leg.txt:1:41: scale must not be 0"));
  EXPECT_THAT(Fault(Joint("scale inf")), HasSubstr("must be a number"));
  EXPECT_THAT(Fault(Joint("scale 1e300")), HasSubstr("must be a number"));
  EXPECT_THAT(Fault(Joint("scale 1 scale 2")), HasSubstr("'scale' is given twice"));
  EXPECT_THAT(Fault(Joint("limits 5 -5")), HasSubstr("leg.txt:1:42: the lower limit is above"));
  EXPECT_THAT(Fault(Joint("limits 5 }")), HasSubstr("the upper limit is missing"));
  EXPECT_THAT(Fault("node { name a length 1 limits 0 1 }"), HasSubstr("limits, but no axis"));
  EXPECT_THAT(Fault("node { name a axis 0 0 0 sensor 1 }"), HasSubstr("axis has no direction"));
  EXPECT_THAT(Fault("node { name a axis 1 0 0 sensor 1.5 }"), HasSubstr("whole number from 0"));
  EXPECT_THAT(Fault("node { name a axis 1 0 0 sensor -1 }"), HasSubstr("whole number from 0"));
  EXPECT_THAT(Fault("node { name a length -1 }"), HasSubstr("cannot be negative"));
  EXPECT_THAT(Fault("node { name a }\nunits mm"),
              HasSubstr("leg.txt:2:1: 'units' must stand before the first node"));
  EXPECT_THAT(Fault("units mm\nunits mm"), HasSubstr("leg.txt:2:1: 'units' is given twice"));
  EXPECT_THAT(Fault(""), HasSubstr("there is no node in it"));
  EXPECT_THAT(Fault("node { name a\n\n"), HasSubstr("leg.txt:3:1: the file ends within a block"));
  EXPECT_THAT(Fault("node { name a } }"), HasSubstr("leg.txt:1:17: '}' is not known here"));
  EXPECT_THAT(Fault("node name"), HasSubstr("leg.txt:1:6: '{' belongs here, not 'name'"));
  EXPECT_THAT(Fault("node { name"), HasSubstr("the file ends where a name is missing"));
  EXPECT_THAT(Fault("node { name }"), HasSubstr("a name is missing before '}'"));
  EXPECT_THAT(Fault(std::string("node \x01", 6)), HasSubstr("leg.txt:1:6: byte 1 is in no text"));
  EXPECT_THAT(Fault("node { name a counts 5 }"), HasSubstr("'counts' is not known here"));
}

TEST(DescriptionFile, AttributesThatDoNotGoTogetherAreFaults) {
  EXPECT_THAT(Fault("node { axis 1 0 0 sensor 1 }"), HasSubstr("the node has no name"));
  EXPECT_THAT(Fault("node { name a axis 1 0 0 }"),
              HasSubstr("leg.txt:1:1: the node 'a' turns, but has no sensor"));
  EXPECT_THAT(Fault("node { name a sensor 1 }"), HasSubstr("has a sensor, but no axis"));
  EXPECT_THAT(Fault("node { name a scale 1 }"), HasSubstr("has a scale, but no axis"));
  EXPECT_THAT(Fault(Joint("length 1")), HasSubstr("is a joint and a rod"));
  EXPECT_THAT(Fault(Joint("slide 1 0 0")), HasSubstr("an axis and a slide"));
  EXPECT_THAT(Fault("node { name a rodaxis 1 0 0 }"), HasSubstr("a rodaxis, but no length"));
}

TEST(DescriptionFile, SensorOrNameGivenTwiceIsAFault) {
  EXPECT_EQ(Fault("node { name a axis 1 0 0 sensor 3\n node { name b axis 1 0 0\nsensor 3 } }"),
            "leg.txt:3:8: sensor 3 is also that of the node 'a' in line 1; an encoder watches one "
            "joint");
  EXPECT_EQ(Fault("node { name a\n node { name a } }"),
            "leg.txt:2:14: the name 'a' is also that of the node in line 1; each node needs its "
            "own");
}

std::string Nested(int depth) {
  std::string text;
  for (int i = 0; i < depth; ++i) text += "node { name n" + std::to_string(i) + "\n";
  return text + std::string(static_cast<std::size_t>(depth), '}');
}

TEST(DescriptionFile, DeepNestingIsAFaultAndNoCrash) {
  EXPECT_EQ(Parse(Nested(200)).nodes.size(), 200u);
  EXPECT_THAT(Fault(Nested(201)), HasSubstr("leg.txt:201:1: nodes are nested more than 200 deep"));
  EXPECT_THAT(Fault(Nested(10000)), HasSubstr("leg.txt:201:1: nodes are nested more than 200"));
  EXPECT_THAT(Fault(std::string(2000000, '{')), HasSubstr("leg.txt:1:1: '{' is not known here"));
}

TEST(DescriptionFile, TooManyNodesAreAFault) {
  std::string text;
  for (int i = 0; i < 10001; ++i) text += "node { name n" + std::to_string(i) + " }\n";
  EXPECT_THAT(Fault(text), HasSubstr("leg.txt:10001:1: there are more than 10000 nodes"));
}

}  // namespace keypose::armature::description_file_test
