// What somebody said of a result: approved, or sent back with a note. Kept in reviews.json.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/result_history.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

inline constexpr char kReviewsFile[] = "reviews.json";

/// What there is to look at, and what was said of it:
/// - revision  of reviews.json
/// - problem   why reviews.json cannot be read, or ""
/// - running   a run is at work, whose results come when it ends
/// - subjects  [{pose, versions, reviews}], `pose` "" for the film
///   - versions  newest first: {id, when, now, gone, mesh, texture, files: [{path, title, film,
///   at}]};
///               `mesh`, `texture` and `at` as FileAt takes them, or ""
///   - reviews   newest first: {index, verdict, note, when, holds, version}: `holds` says that it
///               was said of what is there now, `version` of what it was said ("": not there any
///               more)
/// @param running  as ResultHistory takes it
nlohmann::json ReviewsJson(Snapshot& snapshot, bool running);

struct NewReview {
  std::string pose, version;
  std::string verdict;  ///< "approved" or "sent back"
  std::string note;
};

/// @param when  seconds since 1970
/// @throws UsageError  another verdict, a result sent back without a note, or one of which nothing
/// is left to look at
/// @throws ChangedMeanwhile  reviews.json is not of this revision @throws InputError  it cannot be
/// read
void AddReview(Snapshot& snapshot, const NewReview& review, const std::string& revision,
               double when, bool running);
/// Takes one back. @throws as AddReview
void RemoveReview(Snapshot& snapshot, int index, const std::string& revision);
/// Reviews of a pose that has another name from now on.
void RenameReviewed(const std::filesystem::path& project, const std::string& pose,
                    const std::string& to);

}  // namespace keypose::studio
