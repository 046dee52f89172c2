// What a project's poses and films were after earlier runs, as far as the cache still has it.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/cache/run_history.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

/// A picture or a film among the results, to look at.
struct ResultFile {
  std::string path;   ///< below out/, as it is named there
  std::string title;  ///< of the step that made it
  bool film = false;  ///< else a picture
  std::string at;     ///< as FileAt takes it
  std::string hash;   ///< of its content
};

/// One result of a pose or of the animation, which others came before or after.
struct ResultVersion {
  std::string id;    ///< another content has another one
  std::string when;  ///< "2026-03-01 14:05:09 UTC", of the run that made or found it
  bool now = false;
  /// fingerprints of all steps of the project at that time, by id
  std::map<std::string, std::string> steps;
  std::vector<std::string> gone;  ///< of its own steps, those whose artifact was cleaned away
  std::string mesh;               ///< as FileAt takes it; empty: none (any more)
  std::string texture;            ///< of that mesh, likewise
  std::vector<ResultFile> files;  ///< in the order of the steps
  /// what is looked at first, hash by name: "mesh" and "texture", else films, else frames, else
  /// pictures. Empty: nothing (any more)
  std::map<std::string, std::string> shown;
};

struct ReviewSubject {
  std::string pose;  ///< "": what is made of all poses: the film
  std::vector<const pipeline::Step*> steps;
  std::vector<ResultVersion> versions;  ///< newest first; that of now is the first
};

/// A file of the cache by its address, "FINGERPRINT/NAME": what was listed once is found as long as
/// it is in the cache, whatever has run since.
/// @throws NotFound  it was cleaned away, is no output, or lies elsewhere (a link)
std::filesystem::path FileAt(pipeline::OpenedProject& project, const std::string& at);

class ResultHistory {
 public:
  /// Of each subject at most this many versions.
  static constexpr int kMostVersions = 20;

  /// @param running  a run is at work: what it has made so far is no result yet, as its steps are
  /// of two runs
  /// @pre `snapshot` outlives this object
  explicit ResultHistory(Snapshot& snapshot, bool running = false);

  const std::vector<ReviewSubject>& subjects() const { return subjects_; }
  /// @throws UsageError  there is no such pose
  const ReviewSubject& Subject(const std::string& pose) const;
  /// @throws NotFound  no such version, or it has left the list
  const ResultVersion& Version(const std::string& pose, const std::string& id) const;

  /// What was changed between two versions, and the figures that moved:
  /// - changes  [{step, title, text}]: of these steps and of those that they need
  /// - unknown  [step]: another result, but one of the two was cleaned away
  /// - figures  [{step, title, key, label, unit, before, after, good: {min, max}, main}]: `before`
  ///   or `after` is null where it was not measured; `main`: of the stage's most important ones
  nlohmann::json CompareJson(const std::string& pose, const std::string& before,
                             const std::string& after);

 private:
  using State = std::map<std::string, std::string>;
  struct Moment {
    State steps;
    std::string when;
    bool now = false;
  };
  const std::optional<pipeline::Artifact>& ArtifactOf(const std::string& fingerprint);
  State StateNow(std::string* when) const;
  std::vector<Moment> MomentsOf(const ReviewSubject& subject,
                                const std::vector<pipeline::PastRun>& runs, bool running) const;
  ResultVersion VersionOf(const ReviewSubject& subject, const Moment& moment);
  void AddFiles(const pipeline::Step& step, const pipeline::Artifact& artifact,
                ResultVersion* version, std::map<std::string, std::string>* contents) const;
  void AddShown(const ReviewSubject& subject, ResultVersion* version);
  std::vector<const pipeline::Step*> WithNeeds(const ReviewSubject& subject) const;

  Snapshot& snapshot_;
  std::map<std::string, std::optional<pipeline::Artifact>> artifacts_;
  std::vector<ReviewSubject> subjects_;
};

}  // namespace keypose::studio
