// Requests and answers, free of the HTTP library.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace keypose::studio {

struct Question {
  std::string method, path;
  std::map<std::string, std::string> query;
  std::string body;

  /// @throws UsageError  the query lacks it
  const std::string& Need(const std::string& name) const;
  std::string Get(const std::string& name, const std::string& otherwise = "") const;
  /// The body as JSON. @throws UsageError  it is none, or nested too deep
  nlohmann::json Json() const;
};

struct Answer {
  int status = 200;
  std::string type = "application/json";
  std::string bytes;
  std::filesystem::path file;  ///< sent instead of `bytes`
  std::string download;        ///< name under which the browser saves it
};

Answer JsonAnswer(const nlohmann::json& value);
Answer ErrorAnswer(int status, const std::string& words);
Answer TextAnswer(std::string text);
Answer BytesAnswer(std::string bytes);
/// A JPEG or PNG. Its type is told by its bytes, as names of photographs may lie.
Answer PictureAnswer(const std::filesystem::path& file);

/// What a browser keeps a file under, to ask only whether it has changed; "" if it is not there.
std::string TagOf(const std::filesystem::path& file);

/// The media type by a file's extension.
std::string TypeOf(const std::filesystem::path& file);

/// @throws UsageError  the text is no whole number from `least` to `most`
int WholeNumber(const std::string& text, int least, int most);

}  // namespace keypose::studio
