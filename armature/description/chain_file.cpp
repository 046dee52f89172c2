#include "armature/description/chain_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "armature/description/words.h"

namespace keypose::armature {
namespace {

constexpr std::size_t kMostChains = 1000, kMostAnchors = 10000;

const std::vector<std::string> kTopWords = {"anchor", "chain"};
// With the words that may follow an anchor or a chain, so that a slip in these is told as well.
const std::vector<std::string> kAnchorWords = {"physical", "computer", "anchor", "chain"};
const std::vector<std::string> kChainWords = {"from", "to",     "physical", "computer",
                                              "mode", "anchor", "chain"};

bool Contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

class ChainParser {
 public:
  ChainParser(const std::string& text, const std::string& file, const Armature& armature)
      : file_(file),
        all_words_(SplitWords(text, file_)),
        words_(all_words_, file_),
        armature_(armature) {}

  ChainPlan Parse() {
    while (!words_.AtEnd()) {
      const Word& word = words_.Next();
      if (word.text == "anchor")
        ReadAnchor(word);
      else if (word.text == "chain")
        ReadChain(word);
      else
        words_.RefuseWord(word, kTopWords);
    }
    for (std::size_t c = 0; c < plan_.chains.size(); ++c) Lay(c);
    Order();
    return std::move(plan_);
  }

 private:
  /// What a chain names, with the places of the words.
  struct Given {
    Word begin;
    const Word *from = nullptr, *to = nullptr, *mode = nullptr;
    bool lists_nodes = false;
    std::vector<const Word*> nodes;
  };

  void ReadAnchor(const Word& begin) {
    if (plan_.anchors.size() >= kMostAnchors) words_.Fail(begin, "there are too many anchors");
    Anchor anchor;
    anchor.line = begin.line;
    const Word& place = words_.Peek();
    anchor.name = words_.Name("the anchor's name");
    if (const int other = plan_.FindAnchor(anchor.name); other >= 0)
      words_.Fail(place, fmt::format("the anchor {} is there already, in line {}",
                                     Quoted(anchor.name), AnchorAt(other).line));
    while (!words_.AtEnd() && !Contains(kTopWords, words_.Peek().text)) {
      const Word& key = words_.Next();
      if (!Contains(kAnchorWords, key.text)) words_.RefuseWord(key, kAnchorWords);
      const Word& value = words_.Peek();
      const std::string name = words_.Name("the name of a joint");
      const bool twice = key.text == "physical" ? anchor.node >= 0 : !anchor.computer.empty();
      if (twice) words_.Fail(key, fmt::format("'{}' is given twice for this anchor", key.text));
      if (key.text == "physical")
        anchor.node = NodeNamed(value);
      else
        anchor.computer = name;
    }
    if (anchor.node < 0 || anchor.computer.empty())
      words_.Fail(begin, fmt::format("the anchor {} lacks `{} NAME`", Quoted(anchor.name),
                                     anchor.node < 0 ? "physical" : "computer"));
    plan_.anchors.push_back(anchor);
  }

  void ReadChain(const Word& begin) {
    if (plan_.chains.size() >= kMostChains) words_.Fail(begin, "there are too many chains");
    Chain chain;
    Given given;
    given.begin = begin;
    chain.line = begin.line;
    const Word& place = words_.Peek();
    chain.name = words_.Name("the chain's name");
    for (const Chain& other : plan_.chains)
      if (other.name == chain.name)
        words_.Fail(place, fmt::format("the chain {} is there already, in line {}",
                                       Quoted(chain.name), other.line));
    std::set<std::string> seen;
    while (!words_.AtEnd() && !Contains(kTopWords, words_.Peek().text)) {
      const Word& key = words_.Next();
      if (!Contains(kChainWords, key.text)) words_.RefuseWord(key, kChainWords);
      if (!seen.insert(key.text).second)
        words_.Fail(key, fmt::format("'{}' is given twice for this chain", key.text));
      ReadPart(key.text, &chain, &given);
    }
    for (const char* key : {"from", "to"})
      if (!seen.contains(key))
        words_.Fail(begin, fmt::format("the chain {} lacks `{} ANCHOR`", Quoted(chain.name), key));
    plan_.chains.push_back(std::move(chain));
    given_.push_back(std::move(given));
  }

  void ReadPart(const std::string& key, Chain* chain, Given* given) {
    const Word& value = words_.Peek();
    if (key == "from" || key == "to") {
      words_.Name("the name of an anchor");
      (key == "from" ? given->from : given->to) = &value;
    } else if (key == "mode") {
      words_.Name("the mode");
      if (value.text != "match" && value.text != "exact")
        words_.RefuseWord(value, {"match", "exact"});
      if (value.text == "exact") chain->mode = ChainMode::kExact;
      given->mode = &value;
    } else {
      for (const Word* word : ReadList()) {
        if (key == "physical")
          given->nodes.push_back(word);
        else
          chain->computer.push_back(word->text);
      }
      given->lists_nodes = given->lists_nodes || key == "physical";
    }
  }

  std::vector<const Word*> ReadList() {
    std::vector<const Word*> list;
    words_.Expect("{");
    while (words_.Peek().text != "}") {
      list.push_back(&words_.Peek());
      words_.Name("the name of a joint or a '}'");
    }
    words_.Expect("}");
    return list;
  }

  int NodeNamed(const Word& word) const {
    const int node = armature_.Find(word.text);
    if (node >= 0) return node;
    std::vector<std::string> names;
    for (const ArmatureNode& known : armature_.nodes) names.push_back(known.name);
    words_.Fail(word, fmt::format("the armature has no node {}{}", Quoted(word.text),
                                  DidYouMean(word.text, names)));
  }

  int AnchorNamed(const Word& word) const {
    const int anchor = plan_.FindAnchor(word.text);
    if (anchor >= 0) return anchor;
    std::vector<std::string> names;
    for (const Anchor& known : plan_.anchors) names.push_back(known.name);
    if (names.empty()) words_.Fail(word, "there is no anchor in this file");
    words_.Fail(word, fmt::format("there is no anchor {}{}", Quoted(word.text),
                                  DidYouMean(word.text, names)));
  }

  const Anchor& AnchorAt(int index) const { return plan_.anchors[static_cast<std::size_t>(index)]; }

  /// Finds the ends of a chain and the nodes between them.
  void Lay(std::size_t c) {
    Chain& chain = plan_.chains[c];
    const Given& given = given_[c];
    chain.from = AnchorNamed(*given.from);
    chain.to = AnchorNamed(*given.to);
    const Anchor &from = AnchorAt(chain.from), &to = AnchorAt(chain.to);
    if (from.node == to.node)
      words_.Fail(*given.to, fmt::format("the chain {} begins and ends at one place, node {}",
                                         Quoted(chain.name), NodeName(to.node)));
    const std::vector<int> path = PathBetween(armature_, from.node, to.node);
    if (path.empty())
      words_.Fail(*given.to,
                  fmt::format("nodes {} and {} are not joined: they hang in different trees",
                              NodeName(from.node), NodeName(to.node)));
    chain.nodes = given.lists_nodes ? Along(path, given, chain) : path;
    const std::size_t between = chain.nodes.size() - 2;
    if (chain.mode == ChainMode::kExact && !chain.computer.empty() &&
        chain.computer.size() != between)
      words_.Fail(*given.mode, fmt::format("mode exact needs joint on joint, but between its ends "
                                           "the armature has {} and the computer {}",
                                           between, chain.computer.size()));
  }

  std::string NodeName(int node) const {
    return Quoted(armature_.nodes[static_cast<std::size_t>(node)].name);
  }

  /// The listed nodes, which must come in the order of the path; both ends are added.
  std::vector<int> Along(const std::vector<int>& path, const Given& given, const Chain& chain) {
    std::vector<int> nodes = {path.front()};
    std::size_t reached = 0;
    for (const Word* word : given.nodes) {
      const int node = NodeNamed(*word);
      const auto found = std::find(path.begin(), path.end(), node);
      if (found == path.end())
        words_.Fail(*word, fmt::format("{} is not on the way from {} to {}", Quoted(word->text),
                                       NodeName(path.front()), NodeName(path.back())));
      const auto place = static_cast<std::size_t>(found - path.begin());
      const bool is_end = place == 0 || place + 1 == path.size();
      const bool first = word == given.nodes.front(), last = word == given.nodes.back();
      if (place < reached || (place == reached && !first) || (is_end && !first && !last))
        words_.Fail(*word, fmt::format("{} comes twice or out of order in the chain {}; the order "
                                       "is that from {} to {}",
                                       Quoted(word->text), Quoted(chain.name),
                                       NodeName(path.front()), NodeName(path.back())));
      reached = place;
      if (!is_end) nodes.push_back(node);
    }
    nodes.push_back(path.back());
    return nodes;
  }

  /// Puts the chains in an order in which each near anchor is reached before it is used.
  void Order() {
    std::vector<int> chain_to(plan_.anchors.size(), -1);
    for (std::size_t c = 0; c < plan_.chains.size(); ++c) {
      int& other = chain_to[static_cast<std::size_t>(plan_.chains[c].to)];
      if (other >= 0)
        words_.Fail(*given_[c].to,
                    fmt::format("the chains {} and {} both end at the anchor {}; a place can be "
                                "reached by one only: turn one of them round",
                                Quoted(plan_.chains[static_cast<std::size_t>(other)].name),
                                Quoted(plan_.chains[c].name), Quoted(given_[c].to->text)));
      other = static_cast<int>(c);
    }
    std::vector<Chain> ordered;
    std::vector<bool> placed(plan_.chains.size());
    for (std::size_t c = 0; c < plan_.chains.size(); ++c)
      PlaceBefore(c, chain_to, &placed, &ordered);
    plan_.chains = std::move(ordered);
  }

  /// Appends a chain, and before it those that lead to its near anchor.
  void PlaceBefore(std::size_t c, const std::vector<int>& chain_to, std::vector<bool>* placed,
                   std::vector<Chain>* ordered) {
    std::vector<std::size_t> way;
    for (int next = static_cast<int>(c); next >= 0 && !(*placed)[static_cast<std::size_t>(next)];
         next = chain_to[static_cast<std::size_t>(
             plan_.chains[static_cast<std::size_t>(next)].from)]) {
      const auto here = static_cast<std::size_t>(next);
      if (std::find(way.begin(), way.end(), here) != way.end()) RefuseCircle(way, here);
      way.push_back(here);
    }
    for (auto step = way.rbegin(); step != way.rend(); ++step) {
      (*placed)[*step] = true;
      ordered->push_back(plan_.chains[*step]);
    }
  }

  [[noreturn]] void RefuseCircle(const std::vector<std::size_t>& way, std::size_t met) const {
    std::string names;
    auto step = std::find(way.begin(), way.end(), met);
    for (; step != way.end(); ++step) names = Quoted(plan_.chains[*step].name) + ", " + names;
    names.resize(names.size() - 2);
    words_.Fail(given_[met].begin,
                "the chains " + names +
                    " form a circle: each begins where another ends; one must begin elsewhere");
  }

  std::string file_;
  std::vector<Word> all_words_;
  WordReader words_;
  const Armature& armature_;
  ChainPlan plan_;
  std::vector<Given> given_;
};

}  // namespace

ChainPlan ParseChains(const std::string& text, const std::string& file, const Armature& armature) {
  return ChainParser(text, file, armature).Parse();
}

std::string ChainsText(const Armature& armature, const ChainPlan& plan) {
  const auto name_of = [&](int node) {
    return armature.nodes[static_cast<std::size_t>(node)].name;
  };
  std::string text;
  for (const Anchor& anchor : plan.anchors)
    text += fmt::format("anchor {}  physical {}  computer {}\n", anchor.name, name_of(anchor.node),
                        anchor.computer);
  for (const Chain& chain : plan.chains) {
    const auto anchor_of = [&](int a) { return plan.anchors[static_cast<std::size_t>(a)].name; };
    text += fmt::format("chain {}  from {} to {}\n  physical {{", chain.name, anchor_of(chain.from),
                        anchor_of(chain.to));
    for (std::size_t n = 1; n + 1 < chain.nodes.size(); ++n) text += " " + name_of(chain.nodes[n]);
    text += " }\n";
    if (!chain.computer.empty())
      text += fmt::format("  computer {{ {} }}\n", fmt::join(chain.computer, " "));
    text += chain.mode == ChainMode::kExact ? "  mode exact\n" : "  mode match\n";
  }
  return text;
}

}  // namespace keypose::armature
