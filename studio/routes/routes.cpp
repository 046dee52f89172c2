#include "studio/routes/routes.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "studio/project/changes.h"
#include "studio/project/not_found.h"
#include "studio/routes/pages.h"

namespace keypose::studio {

Routes::Routes(std::filesystem::path folder)
    : project_(std::move(folder)), pages_(AllPages(project_)) {
  for (const auto& page : pages_) page->AddTo(table_);
}

/// What somebody has asked to change must be seen by the next question, and by the other tabs.
void Routes::Tell(Changes changes) {
  if (changes == Changes::kQuietly) project_.Forget();
  if (changes == Changes::kProject) project_.TellOfOwnChange();
}

Answer Answered(const std::function<Answer()>& make) {
  try {
    return make();
  } catch (const ChangedMeanwhile& error) {
    return ErrorAnswer(409, error.what());
  } catch (const NotFound& error) {
    return ErrorAnswer(404, error.what());
  } catch (const LockedError& error) {
    return ErrorAnswer(409, error.what());
  } catch (const DiskError& error) {
    return ErrorAnswer(500, error.what());
  } catch (const Error& error) {
    return ErrorAnswer(400, error.what());
  } catch (const nlohmann::json::exception& error) {
    return ErrorAnswer(400, "the request is incomplete: " + JsonFault(error));
  } catch (const std::filesystem::filesystem_error& error) {
    return ErrorAnswer(500, error.path1().string() + ": " + error.code().message());
  } catch (const std::exception& error) {
    return ErrorAnswer(500, fmt::format("a bug in the studio: {}", error.what()));
  }
}

Answer Routes::Handle(const Question& question) {
  return Answered([&] {
    const RouteTable::Route* route = table_.Find(question.method, question.path);
    if (!route) return ErrorAnswer(404, "there is nothing at this address");
    Answer answer = route->handler(question);
    Tell(route->changes);
    return answer;
  });
}

}  // namespace keypose::studio
