// What was measured on the way to a result. It goes to the report only with the result that is
// taken.
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

/// Names and values, as a stage's report has them, and sentences that a person should know.
class Measurements {
 public:
  /// A whole JSON text: an array or an object.
  struct Json {
    std::string text;
    bool operator==(const Json&) const = default;
  };
  using Value = std::variant<bool, std::int64_t, double, std::string, Json>;

  /// A name that is there already gets the new value.
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
  /// Null when nothing has the name.
  const Value* Find(std::string_view name) const;

  void Report(StageContext& stage) const;

 private:
  void Put(std::string_view name, Value value);

  std::vector<std::pair<std::string, Value>> values_;
  std::vector<std::string> warnings_;
};

}  // namespace keypose::reconstruct
