#include "studio/http/answers.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <fstream>
#include <string_view>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

Answer JsonAnswer(const json& value) {
  // A file's name may hold bytes that are no text.
  return {
      200, "application/json", value.dump(-1, ' ', false, json::error_handler_t::replace), {}, {}};
}

Answer ErrorAnswer(int status, const std::string& words) {
  Answer answer = JsonAnswer({{"error", words}});
  answer.status = status;
  return answer;
}

Answer TextAnswer(std::string text) { return {200, "text/plain", std::move(text), {}, {}}; }
Answer BytesAnswer(std::string bytes) {
  return {200, "application/octet-stream", std::move(bytes), {}, {}};
}

std::string TagOf(const fs::path& file) {
  struct stat stat;
  if (::stat(file.c_str(), &stat) != 0) return "";
  return fmt::format("\"{:x}-{:x}-{:x}{:x}\"", stat.st_ino, stat.st_size, stat.st_mtim.tv_sec,
                     stat.st_mtim.tv_nsec);
}

std::string TypeOf(const fs::path& file) {
  static const std::map<std::string, std::string> kTypes = {
      {".png", "image/png"},  {".jpg", "image/jpeg"},        {".jpeg", "image/jpeg"},
      {".html", "text/html"}, {".json", "application/json"}, {".mp4", "video/mp4"},
      {".gif", "image/gif"},  {".glb", "model/gltf-binary"}, {".txt", "text/plain"}};
  const auto found = kTypes.find(LowerExtension(file));
  return found == kTypes.end() ? "application/octet-stream" : found->second;
}

Answer PictureAnswer(const fs::path& file) {
  char head[4] = {};
  std::ifstream(file, std::ios::binary).read(head, sizeof head);
  const bool png = std::string_view(head, sizeof head) == "\x89PNG";
  return {200, png ? "image/png" : "image/jpeg", {}, file, {}};
}

int WholeNumber(const std::string& text, int least, int most) {
  std::size_t end = 0;
  int value = least - 1;
  try {
    value = std::stoi(text, &end);
  } catch (const std::exception&) {
    end = 0;
  }
  if (end != text.size() || value < least || value > most)
    throw UsageError(fmt::format("'{}' must be a whole number from {} to {}", text, least, most));
  return value;
}

const std::string& Question::Need(const std::string& name) const {
  const auto found = query.find(name);
  if (found == query.end()) throw UsageError(fmt::format("the request lacks '{}'", name));
  return found->second;
}

std::string Question::Get(const std::string& name, const std::string& otherwise) const {
  const auto found = query.find(name);
  return found == query.end() ? otherwise : found->second;
}

json Question::Json() const {
  if (!IsShallowJson(body)) throw UsageError("the request is nested too deep");
  const json value = json::parse(body, nullptr, false);
  if (!value.is_object()) throw UsageError("the request is not a JSON object");
  return value;
}

}  // namespace keypose::studio
