#include "core/io/text/xml_depth.h"

#include <algorithm>

#include "core/values/errors.h"

namespace keypose {

// Comments and quoted values are skipped as the libraries do. Other constructs that begin with '<!'
// are not skipped, so a level may be counted twice, but none is missed.
void RequireShallowXml(std::string_view text, const std::string& where) {
  constexpr int kMostLevels = 100;
  int level = 0;
  for (std::size_t at = text.find('<'); at < text.size(); at = text.find('<', at)) {
    const auto begins = [&](const char* mark) { return text.substr(at).starts_with(mark); };
    const auto behind = [&](const char* mark) {
      return std::min(text.size(), text.find(mark, at));
    };
    if (begins("<!--")) {
      at = behind("-->");
    } else if (begins("<![CDATA[")) {
      at = behind("]]>");
    } else if (begins("</")) {
      --level;
      at += 2;
    } else if (begins("<!") || begins("<?")) {
      at += 2;
    } else {
      char quote = 0;
      for (++at; at < text.size() && (quote || text[at] != '>'); ++at) {
        if (quote ? text[at] == quote : text[at] == '"' || text[at] == '\'')
          quote = quote ? 0 : text[at];
      }
      level += at == text.size() || text[at - 1] != '/';
    }
    if (level > kMostLevels)
      throw InputError(where + ": its elements are nested more than 100 levels deep");
  }
}

}  // namespace keypose
