#include "armature/description/chain_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "armature/description/description_file.h"
#include "armature/testing/theropods.h"
#include "core/values/errors.h"

namespace keypose::armature::chain_file_test {

using ::testing::HasSubstr;

// hips - s1 - s2 - head; hips - t1 - tip; other hangs in a tree of its own.
Armature Figure() {
  return DescriptionFile::Parse(
             "node { name hips node { name s1 axis 1 0 0 sensor 0 node { name s2 length 1 node { "
             "name head length 1 } } } node { name t1 length 1 node { name tip length 1 } } }"
             "node { name other }",
             "f.txt")
      .armature();
}

const char* const kAnchors = R"(anchor hips physical hips computer Hips # both
anchor head computer Head physical head
anchor tip physical tip computer Tip
anchor other physical other computer Other
)";

ChainPlan Parse(const std::string& chains) {
  return ParseChains(kAnchors + chains, "c.txt", Figure());
}

std::string Fault(const std::string& chains, const std::string& before = kAnchors) {
  try {
    ParseChains(before + chains, "c.txt", Figure());
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

TEST(ParseChains, ReadsAnchorsAndChains) {
  const Armature figure = Figure();
  const ChainPlan plan = Parse(
      "chain neck from hips to head physical { s2 } computer { Neck } mode exact\n"
      "chain tail from hips to tip");
  ASSERT_EQ(plan.anchors.size(), 4u);
  EXPECT_EQ(plan.anchors[1].name, "head");
  EXPECT_EQ(plan.anchors[1].computer, "Head");
  ASSERT_EQ(plan.chains.size(), 2u);
  EXPECT_EQ(plan.chains[0].mode, ChainMode::kExact);
  EXPECT_EQ(plan.chains[0].nodes,
            (std::vector<int>{figure.Find("hips"), figure.Find("s2"), figure.Find("head")}));
  EXPECT_EQ(plan.chains[0].computer, std::vector<std::string>{"Neck"});
  EXPECT_EQ(plan.chains[1].nodes, PathBetween(figure, figure.Find("hips"), figure.Find("tip")));
  EXPECT_EQ(plan.chains[1].line, 6);
}

TEST(ParseChains, PutsChainsInTheOrderInWhichTheyCanBeMatched) {
  const ChainPlan plan = Parse("chain b from head to tip chain a from hips to head");
  EXPECT_EQ(plan.chains[0].name, "a");
  EXPECT_EQ(plan.chains[1].name, "b");
}

TEST(ParseChains, EndsMayBeListedToo) {
  EXPECT_EQ(Parse("chain n from hips to head physical { hips s1 head }").chains[0].nodes.size(),
            3u);
}

TEST(ParseChains, ChainThroughAMissingJointIsAFault) {
  EXPECT_EQ(Fault("chain n from hips to head\n physical { s1 s22 }"),
            "c.txt:6:16: the armature has no node 's22'; did you mean 's2'?");
  EXPECT_EQ(Fault("", "anchor a physical hisp computer H"),
            "c.txt:1:19: the armature has no node 'hisp'; did you mean 'hips'?");
  EXPECT_EQ(Fault("chain n from hips to haed"),
            "c.txt:5:22: there is no anchor 'haed'; did you mean 'head'?");
  EXPECT_THAT(Fault("chain n from a to b", ""), HasSubstr("there is no anchor in this file"));
}

TEST(ParseChains, CircleIsAFault) {
  EXPECT_EQ(Fault("chain a from hips to head\nchain b from head to tip\nchain c from tip to hips"),
            "c.txt:5:1: the chains 'b', 'c', 'a' form a circle: each begins where another ends; "
            "one must begin elsewhere");
  EXPECT_THAT(Fault("chain a from hips to hips"), HasSubstr("begins and ends at one place"));
}

TEST(ParseChains, TwoChainsToOneAnchorAreAFault) {
  EXPECT_THAT(Fault("chain a from hips to head\nchain b from tip to head"),
              HasSubstr("c.txt:6:21: the chains 'a' and 'b' both end at the anchor 'head'"));
}

TEST(ParseChains, NodesThatAreNotOnTheWayAreAFault) {
  EXPECT_THAT(Fault("chain n from hips to head physical { t1 }"),
              HasSubstr("'t1' is not on the way from 'hips' to 'head'"));
  EXPECT_THAT(Fault("chain n from hips to head physical { s2 s1 }"), HasSubstr("out of order"));
  EXPECT_THAT(Fault("chain n from hips to head physical { s1 s1 }"), HasSubstr("comes twice"));
  EXPECT_THAT(Fault("chain n from hips to head physical { hips hips }"), HasSubstr("comes twice"));
  EXPECT_THAT(Fault("chain n from hips to head physical { s1 hips }"), HasSubstr("comes twice"));
  EXPECT_THAT(Fault("chain n from hips to other"), HasSubstr("are not joined"));
}

TEST(ParseChains, FaultsNameLineAndColumn) {
  EXPECT_THAT(Fault("anker x"), HasSubstr("c.txt:5:1: 'anker' is not known here; did you mean "
                                          "'anchor'?"));
  EXPECT_THAT(Fault("chain n from hips too head"),
              HasSubstr("c.txt:5:19: 'too' is not known here; did you mean 'to'?"));
  EXPECT_THAT(Fault("chain n from hips"), HasSubstr("the chain 'n' lacks `to ANCHOR`"));
  EXPECT_THAT(Fault("chain n from hips from hips"), HasSubstr("'from' is given twice"));
  EXPECT_THAT(Fault("chain n from hips to head physical { s1"),
              HasSubstr("the file ends where the name of a joint or a '}' is missing"));
  EXPECT_THAT(Fault("chain n from hips to head mode best"), HasSubstr("'best' is not known here"));
  EXPECT_THAT(Fault("chain n from hips to head mode exact computer { A }"),
              HasSubstr("the armature has 2 and the computer 1"));
  EXPECT_THAT(Fault("chain n from hips to head chain n from hips to tip"),
              HasSubstr("the chain 'n' is there already, in line 5"));
  EXPECT_THAT(Fault("anchor hips physical tip computer T"),
              HasSubstr("the anchor 'hips' is there already, in line 1"));
  EXPECT_THAT(Fault("anchor x physical tip"), HasSubstr("the anchor 'x' lacks `computer NAME`"));
  EXPECT_THAT(Fault("anchor x physical tip physical tip"), HasSubstr("'physical' is given twice"));
}

TEST(ChainsText, IsReadAgainAsTheSamePlan) {
  const Armature theropod = MakeTheropod();
  const ChainPlan made = MakeTheropodChains(theropod);
  const ChainPlan read = ParseChains(ChainsText(theropod, made), "c.txt", theropod);
  ASSERT_EQ(read.chains.size(), made.chains.size());
  for (std::size_t c = 0; c < made.chains.size(); ++c) {
    EXPECT_EQ(read.chains[c].name, made.chains[c].name);
    EXPECT_EQ(read.chains[c].nodes, made.chains[c].nodes);
    EXPECT_EQ(read.chains[c].computer, made.chains[c].computer);
    EXPECT_EQ(read.chains[c].mode, made.chains[c].mode);
  }
}

}  // namespace keypose::armature::chain_file_test
