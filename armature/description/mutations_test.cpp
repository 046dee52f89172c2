// Thousands of damaged description files: each is read, or refused with its line.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <regex>

#include "armature/description/chain_file.h"
#include "armature/description/description_file.h"
#include "armature/testing/theropods.h"
#include "core/values/errors.h"

namespace keypose::armature::mutations_test {

/// Some thousands, or as many as the environment variable KEYPOSE_MUTANTS says.
int Mutants() {
  const char* wanted = std::getenv("KEYPOSE_MUTANTS");
  return wanted ? std::max(1, std::atoi(wanted)) : 4000;
}

/// One to four damages: bytes changed, pieces cut out, doubled or moved, words of the format put
/// in.
std::string Mutant(const std::string& text, std::mt19937* random) {
  static const char* const kWords[] = {
      "node {",   "}",        "{",        "sensor 3", "scale 0",     "axis 0 0 0", "#",
      "1e9",      "rodaxis",  "units mm", "\xff",     "name pelvis", "chain ",     "to",
      "physical", "computer", "anchor ",  "-1",       "limits 3 -1"};
  std::string mutant = text;
  const auto pick = [&](std::size_t count) {
    return static_cast<std::size_t>((*random)() % count);
  };
  for (std::size_t rounds = 1 + pick(4); rounds > 0; --rounds) {
    const std::size_t at = pick(mutant.size() + 1), length = pick(40);
    const std::string piece = mutant.substr(at, length);
    switch (pick(5)) {
      case 0:
        if (at < mutant.size()) mutant[at] = static_cast<char>((*random)());
        break;
      case 1:
        mutant.erase(at, length);
        break;
      case 2:
        mutant.insert(at, piece);
        break;
      case 3:
        mutant.insert(pick(mutant.size() + 1), piece);
        break;
      default:
        mutant.insert(at, kWords[pick(std::size(kWords))]);
    }
  }
  return mutant;
}

/// @return whether the text was refused, and how
template <class Read>
bool IsRefusedWithItsLine(const std::string& text, const Read& read) {
  static const std::regex place("^d\\.txt:([0-9]+):([0-9]+): [^]+");
  try {
    read(text);
    return false;
  } catch (const InputError& error) {
    const std::string said = error.what();
    std::smatch match;
    EXPECT_TRUE(std::regex_match(said, match, place)) << said;
    const auto lines = 1 + std::count(text.begin(), text.end(), '\n');
    EXPECT_LE(std::stol(match[1]), lines) << said;
    return true;
  }
}

TEST(MutatedFiles, DescriptionsAreReadOrRefusedWithTheirLine) {
  std::mt19937 random(7);
  const std::string whole = DescriptionText(MakeTheropod());
  const int mutants = Mutants();
  int refused = 0;
  for (int i = 0; i < mutants; ++i)
    refused += IsRefusedWithItsLine(Mutant(whole, &random), [](const std::string& text) {
      EXPECT_EQ(DescriptionFile::Parse(text, "d.txt").Text(), text);
    });
  EXPECT_GT(refused, mutants / 2);
  EXPECT_LT(refused, mutants);
  std::printf("%d of %d were refused, each with its line\n", refused, mutants);
}

TEST(MutatedFiles, ChainsAreReadOrRefusedWithTheirLine) {
  std::mt19937 random(8);
  const Armature theropod = MakeTheropod();
  const std::string whole = ChainsText(theropod, MakeTheropodChains(theropod));
  const int mutants = Mutants();
  int refused = 0;
  for (int i = 0; i < mutants; ++i)
    refused += IsRefusedWithItsLine(Mutant(whole, &random), [&](const std::string& text) {
      for (const Chain& chain : ParseChains(text, "d.txt", theropod).chains)
        EXPECT_GE(chain.nodes.size(), 2u);
    });
  EXPECT_GT(refused, mutants / 2);
  EXPECT_LT(refused, mutants);
  std::printf("%d of %d were refused, each with its line\n", refused, mutants);
}

}  // namespace keypose::armature::mutations_test
