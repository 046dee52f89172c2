#include "export/fbx/fbx_document.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

using namespace std::string_view_literals;

constexpr std::int64_t kDocumentId = 1;
// Belongs to kFbxCreationTime, as does the code in the footer.
constexpr std::string_view kFileId =
    "\x28\xb3\x2a\xeb\xb6\x24\xcc\xc2\xbf\xc8\xb0\x2a\xa9\x2b\xfc\xf1"sv;
constexpr double kCentimetresPerUnit = 100;
constexpr std::int32_t kCustomRate = 14;

struct TimeMode {
  double fps;
  std::int32_t mode;
};
/// Autodesk's FbxTime::EMode, without the modes that Blender does not know.
constexpr std::array<TimeMode, 14> kTimeModes = {{{24, 11},
                                                  {25, 10},
                                                  {30, 6},
                                                  {48, 5},
                                                  {50, 4},
                                                  {60, 3},
                                                  {72, 16},
                                                  {96, 15},
                                                  {100, 2},
                                                  {120, 1},
                                                  {24 / 1.001, 13},
                                                  {30 / 1.001, 9},
                                                  {60 / 1.001, 17},
                                                  {120 / 1.001, 18}}};

/// The mode of a rate that the format knows, to the last few bits; else kCustomRate.
std::int32_t ModeOf(double fps) {
  const auto known =
      std::find_if(kTimeModes.begin(), kTimeModes.end(), [&](const TimeMode& candidate) {
        return std::abs(candidate.fps - fps) < 1e-12 * candidate.fps;
      });
  return known == kTimeModes.end() ? kCustomRate : known->mode;
}

FbxRecord TimeStamp() {
  return {"CreationTimeStamp",
          {},
          {{"Version", {1000}},
           {"Year", {1970}},
           {"Month", {1}},
           {"Day", {1}},
           {"Hour", {10}},
           {"Minute", {0}},
           {"Second", {0}},
           {"Millisecond", {0}}}};
}

FbxRecord SceneInfo(const std::string& title) {
  const FbxRecord meta{"MetaData",
                       {},
                       {{"Version", {100}},
                        {"Title", {title}},
                        {"Subject", {""}},
                        {"Author", {""}},
                        {"Keywords", {""}},
                        {"Revision", {""}},
                        {"Comment", {""}}}};
  const std::string file = title + ".fbx";
  return {"SceneInfo",
          {FbxName("GlobalInfo", "SceneInfo"), "UserData"},
          {{"Type", {"UserData"}},
           {"Version", {100}},
           meta,
           FbxProperties({{"DocumentUrl", "KString", "Url", "", file},
                          {"SrcDocumentUrl", "KString", "Url", "", file},
                          {"Original", "Compound", "", ""},
                          {"Original|ApplicationVendor", "KString", "", "", "Keypose"},
                          {"Original|ApplicationName", "KString", "", "", "Keypose"},
                          {"Original|FileName", "KString", "", "", file},
                          {"LastSaved", "Compound", "", ""},
                          {"LastSaved|ApplicationVendor", "KString", "", "", "Keypose"},
                          {"LastSaved|ApplicationName", "KString", "", "", "Keypose"}})}};
}

FbxRecord HeaderExtension(const std::string& title) {
  return {"FBXHeaderExtension",
          {},
          {{"FBXHeaderVersion", {1003}},
           {"FBXVersion", {kFbxVersion}},
           {"EncryptionType", {0}},
           TimeStamp(),
           {"Creator", {"Keypose"}},
           SceneInfo(title)}};
}

FbxRecord GlobalSettings(const FbxDocument& document) {
  const std::int32_t mode = ModeOf(document.fps);
  const double custom_fps = mode == kCustomRate ? document.fps : -1;
  return {"GlobalSettings",
          {},
          {{"Version", {1000}},
           FbxProperties({{"UpAxis", "int", "Integer", "", 1},
                          {"UpAxisSign", "int", "Integer", "", 1},
                          {"FrontAxis", "int", "Integer", "", 2},
                          {"FrontAxisSign", "int", "Integer", "", 1},
                          {"CoordAxis", "int", "Integer", "", 0},
                          {"CoordAxisSign", "int", "Integer", "", 1},
                          {"OriginalUpAxis", "int", "Integer", "", 1},
                          {"OriginalUpAxisSign", "int", "Integer", "", 1},
                          {"UnitScaleFactor", "double", "Number", "", kCentimetresPerUnit},
                          {"OriginalUnitScaleFactor", "double", "Number", "", kCentimetresPerUnit},
                          {"AmbientColor", "ColorRGB", "Color", "", 0.0, 0.0, 0.0},
                          {"DefaultCamera", "KString", "", "", "Producer Perspective"},
                          {"TimeMode", "enum", "", "", mode},
                          {"TimeProtocol", "enum", "", "", 2},
                          {"SnapOnFrameMode", "enum", "", "", 0},
                          {"TimeSpanStart", "KTime", "Time", "", FbxTicks(0)},
                          {"TimeSpanStop", "KTime", "Time", "", FbxTicks(document.seconds)},
                          {"CustomFrameRate", "double", "Number", "", custom_fps}})}};
}

FbxRecord Documents(const FbxDocument& document) {
  const FbxRecord properties =
      FbxProperties({{"SourceObject", "object", "", ""},
                     {"ActiveAnimStackName", "KString", "", "", document.animation}});
  return {"Documents",
          {},
          {{"Count", {1}},
           {"Document",
            {kDocumentId, document.title, "Scene"},
            {properties, {"RootNode", {std::int64_t{0}}}}}}};
}

/// How many objects of each type there are.
FbxRecord Definitions(const FbxObjects& objects) {
  std::map<std::string, std::int32_t> counts{{"GlobalSettings", 1}};
  for (const FbxRecord& object : objects.objects) ++counts[object.name];
  FbxRecord definitions{
      "Definitions", {}, {{"Version", {100}}, {"Count", {SizeOf(objects.objects) + 1}}}};
  for (const auto& [type, count] : counts)
    definitions.records.push_back({"ObjectType", {type}, {{"Count", {count}}}});
  return definitions;
}

FbxRecord Takes(const FbxDocument& document) {
  FbxRecord takes{"Takes", {}, {{"Current", {document.animation}}}};
  if (document.animation.empty()) return takes;
  const std::int64_t end = FbxTicks(document.seconds);
  takes.records.push_back({"Take",
                           {document.animation},
                           {{"FileName", {document.animation + ".tak"}},
                            {"LocalTime", {FbxTicks(0), end}},
                            {"ReferenceTime", {FbxTicks(0), end}}}});
  return takes;
}

}  // namespace

std::int64_t FbxTicks(double seconds) { return std::llround(seconds * kFbxTicksPerSecond); }

void FbxObjects::Connect(std::int64_t child, std::int64_t parent, const std::string& property) {
  if (property.empty())
    connections.push_back({"C", {"OO", child, parent}, {}});
  else
    connections.push_back({"C", {"OP", child, parent, property}, {}});
}

FbxRecord FbxProperties(const std::vector<std::vector<FbxValue>>& properties) {
  FbxRecord list{"Properties70", {}, {}};
  for (const auto& property : properties) list.records.push_back({"P", property, {}});
  return list;
}

std::vector<FbxRecord> FbxFile(const FbxDocument& document, FbxObjects objects) {
  std::vector<FbxRecord> records;
  records.push_back(HeaderExtension(document.title));
  records.push_back({"FileId", {FbxValue::Binary(kFileId)}, {}});
  records.push_back({"CreationTime", {kFbxCreationTime}, {}});
  records.push_back({"Creator", {"Keypose"}, {}});
  records.push_back(GlobalSettings(document));
  records.push_back(Documents(document));
  records.push_back({"References", {}, {}});
  records.push_back(Definitions(objects));
  records.push_back({"Objects", {}, std::move(objects.objects)});
  records.push_back({"Connections", {}, std::move(objects.connections)});
  records.push_back(Takes(document));
  return records;
}

}  // namespace keypose::exporting
