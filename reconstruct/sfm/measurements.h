// Measurements of a result. They are reported only if the result is used.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace keypose {
class StageContext;
}

namespace keypose::reconstruct {

/// Names and values for a stage's report, and warnings.
class Measurements {
 public:
  /// A whole JSON text: an array or an object.
  struct Json {
    std::string text;
    bool operator==(const Json&) const = default;
  };
  using Value = std::variant<bool, std::int64_t, double, std::string, Json>;

  /// Replaces the value of an existing name.
  void Add(std::string_view name, bool value) { Put(name, value); }
  void Add(std::string_view name, int value) { Put(name, static_cast<std::int64_t>(value)); }
  void Add(std::string_view name, double value) { Put(name, value); }
  void Add(std::string_view name, const std::string& value) { Put(name, value); }
  void Add(std::string_view name, const char* value) { Put(name, std::string(value)); }
  void AddJson(std::string_view name, std::string text) { Put(name, Json{std::move(text)}); }
  /// As StageContext::Warn.
  void Warn(std::string sentence) { warnings_.push_back(std::move(sentence)); }

  /// In the order in which they were first added.
  const std::vector<std::pair<std::string, Value>>& values() const { return values_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Null when there is no such name.
  const Value* Find(std::string_view name) const;

  void Report(StageContext& stage) const;

 private:
  void Put(std::string_view name, Value value);

  std::vector<std::pair<std::string, Value>> values_;
  std::vector<std::string> warnings_;
};

}  // namespace keypose::reconstruct
