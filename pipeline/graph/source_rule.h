// What a step may take from a project by a word such as `$masks`: the table `sources` of a pipeline
// file, and what poses, shots and the project name by its words.
#pragma once

#include <string>
#include <vector>

#include "pipeline/text/setting.h"

namespace keypose::pipeline {

// The words that the runner itself knows, each for what a table cannot say. All others stand in
// pipeline.yaml and performance.yaml.
inline constexpr char kTimelineWord[] = "timeline";  ///< made from the file: it lies nowhere
inline constexpr char kRunWord[] = "run";            ///< made from the results of all other steps
/// The films of a shot that has no masks: there when something is missing.
inline constexpr char kUnmaskedWord[] = "unmasked";
/// The short form of a pose. Two poses must not share photographs; their pixels give the time left.
inline constexpr char kPhotosWord[] = "photos";
inline constexpr char kVideoWord[] = "video";  ///< the short form of a shot; see kUnmaskedWord
/// A filmed shot needs one: the frames that it shows are looked for, and give the timeline.
inline constexpr char kFilmWord[] = "film";
/// Values of options that are made from the file; see pipeline/graph/build_graph.cpp.
inline const std::vector<std::string> kOptionWords = {"fps", "film_fps", "shows", "keys"};

// Keys that are no words of the table.
inline const std::vector<std::string> kPoseKeys = {"method", "options"};
inline const std::vector<std::string> kShotKeys = {"options"};  ///< of a performance
inline const std::vector<std::string> kFilmedShotKeys = {"fps", "shows"};
inline const std::vector<std::string> kFileKeys = {
    "name",     "kind", "poses",   "shots", "shot",    "template",
    "timeline", "fps",  "options", "steps", "sources", "default_timeline"};

/// Whose a source is: where the word is a key, and how many files it gives.
enum class SourceOf {
  kPose,    ///< one for each pose, or each shot of a performance
  kPair,    ///< the template's and the pose's, where both are there
  kShot,    ///< of the filmed shot; in a performance as kPose
  kProject  ///< one, named at the top of the file
};

/// A line of the table `sources`.
struct SourceRule {
  std::string word;  ///< without the $
  Where where;
  SourceOf of = SourceOf::kPose;
  /// Where it lies unless the file names it, the first that is there. `{pose}` or `{shot}` and
  /// words that stand before it in the table are filled in; a name that ends in `.*` is found with
  /// any ending.
  std::vector<Setting> defaults;
  bool always = false;   ///< the default counts also where nothing is there: then that is an error
  std::string required;  ///< what is said where a step takes it and nothing is there
  std::string unpaired;  ///< of a pair: what to do for a pose without it, while another has it
  std::string no_fit;    ///< why poses with `method: fit` do not use it
  std::string kind;      ///< only projects of this `kind` may name it; empty: all
};

/// A path that a pose, a shot or the project names by a word.
struct GivenSource {
  std::string word;
  Setting path;
  Where key;          ///< where the word stands
  std::string fault;  ///< why the value is no path, with its place; empty: it is one
};

/// A part of the file whose keys may be words of the table. Whether they are is known once the
/// project's file lies over the default one: see CheckSources.
struct GivesSources {
  std::vector<GivenSource> given;  ///< in the order of the file

  /// The path that it names by a word; null: none.
  const Setting* Given(const std::string& word) const {
    for (const GivenSource& source : given)
      if (source.word == word && source.fault.empty()) return &source.path;
    return nullptr;
  }
};

}  // namespace keypose::pipeline
