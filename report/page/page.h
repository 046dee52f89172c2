// The page and report.json, made of the contents.
#pragma once

#include <string>

#include "report/evidence/contents.h"

namespace keypose::report {

/// The text of index.html. Says which parts are missing.
std::string BuildPage(const Contents& contents, const Encoder& encode);
/// The text of report.json.
std::string BuildJson(const Contents& contents);

}  // namespace keypose::report
