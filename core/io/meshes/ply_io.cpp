#include "core/io/meshes/ply_io.h"

#include <pcl/io/ply/ply_parser.h>

#include <charconv>
#include <cstdint>
#include <fstream>
#include <functional>
#include <memory>
#include <sstream>

#include "core/values/errors.h"

namespace keypose {
namespace ply = pcl::io::ply;
namespace {

/// Collects the values from the callbacks of PCL's parser.
class Collector {
 public:
  explicit Collector(PlyTable& table) : table_(table) {}

  void Register(ply::ply_parser& parser) {
    parser.error_callback(
        [this](std::size_t line, const std::string& text) { Remember(line, text); });
    parser.warning_callback(
        [this](std::size_t line, const std::string& text) { Remember(line, text); });
    parser.info_callback([](std::size_t, const std::string&) {});
    parser.element_definition_callback([this](const std::string& name, std::size_t count) {
      PlyElement& element = table_[name];
      element.count = count;
      return std::tuple<std::function<void()>, std::function<void()>>([] {}, [] {});
    });
    ply::ply_parser::scalar_property_definition_callbacks_type scalars;
    RegisterScalars<ply::int8, ply::int16, ply::int32, ply::uint8, ply::uint16, ply::uint32,
                    ply::float32, ply::float64>(scalars);
    parser.scalar_property_definition_callbacks(scalars);
    ply::ply_parser::list_property_definition_callbacks_type lists;
    RegisterLists<ply::uint8>(lists);
    RegisterLists<ply::uint16>(lists);
    RegisterLists<ply::uint32>(lists);
    parser.list_property_definition_callbacks(lists);
  }

  const std::string& fault() const { return fault_; }

 private:
  void Remember(std::size_t line, const std::string& text) {
    if (fault_.empty()) fault_ = "line " + std::to_string(line) + ": " + text;
  }

  template <class... Scalars, class Callbacks>
  void RegisterScalars(Callbacks& callbacks) {
    (RegisterScalar<Scalars>(callbacks), ...);
  }
  template <class Scalar, class Callbacks>
  void RegisterScalar(Callbacks& callbacks) {
    callbacks.template get<Scalar>() = [this](const std::string& element,
                                              const std::string& property) {
      std::vector<double>* column = &table_[element].scalars[property];
      return std::function<void(Scalar)>(
          [column](Scalar value) { column->push_back(static_cast<double>(value)); });
    };
  }
  template <class Size, class Callbacks>
  void RegisterLists(Callbacks& callbacks) {
    RegisterListsOf<Size, ply::int8, ply::int16, ply::int32, ply::uint8, ply::uint16, ply::uint32,
                    ply::float32, ply::float64>(callbacks);
  }
  template <class Size, class... Scalars, class Callbacks>
  void RegisterListsOf(Callbacks& callbacks) {
    (RegisterList<Size, Scalars>(callbacks), ...);
  }
  template <class Size, class Scalar, class Callbacks>
  void RegisterList(Callbacks& callbacks) {
    callbacks.template get<Size, Scalar>() = [this](const std::string& element,
                                                    const std::string& property) {
      PlyList* list = &table_[element].lists[property];
      return std::tuple<std::function<void(Size)>, std::function<void(Scalar)>,
                        std::function<void()>>(
          [](Size) {}, [list](Scalar value) { list->values.push_back(static_cast<double>(value)); },
          [list] { list->offsets.push_back(list->values.size()); });
    };
  }

  PlyTable& table_;
  std::string fault_;
};

/// Checks the header's counts, which PCL believes: it has kept running where there was nothing to
/// read. Each row must take at least one byte of the file.
void RequireCountsThatFit(const std::filesystem::path& path) {
  const std::uintmax_t bytes = std::filesystem::file_size(path);
  std::ifstream in(path, std::ios::binary);
  int number = 0;
  for (std::string line; std::getline(in, line) && line.rfind("end_header", 0) != 0;) {
    ++number;
    std::istringstream words(line);
    std::string keyword, name, count;
    if (!(words >> keyword >> name >> count) || keyword != "element") continue;
    std::uintmax_t rows = 0;
    const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), rows);
    if (error != std::errc() || end != count.data() + count.size() || rows > bytes)
      throw InputError("cannot read PLY file " + path.string() + ": line " +
                       std::to_string(number) + " claims " + count + " of '" + name +
                       "', more than the file's " + std::to_string(bytes) +
                       " bytes can hold; it is truncated or damaged");
  }
}

}  // namespace

PlyTable ReadPly(const std::filesystem::path& path) {
  RequireCountsThatFit(path);
  PlyTable table;
  Collector collector(table);
  ply::ply_parser parser;
  collector.Register(parser);
  const bool complete = parser.parse(path.string());
  bool counts_hold = true;
  for (const auto& [name, element] : table) {
    for (const auto& [property, column] : element.scalars)
      counts_hold &= column.size() == element.count;
    for (const auto& [property, list] : element.lists)
      counts_hold &= list.offsets.size() == element.count + 1;
  }
  if (!complete || !counts_hold)
    throw InputError("cannot read PLY file " + path.string() + ": " +
                     (collector.fault().empty() ? "it ends before its header says; it is truncated"
                                                : collector.fault()));
  return table;
}

}  // namespace keypose
