# cmake -DFILE=keypose_import.py -DOUTPUT=add_on.cpp -P embed_add_on.cmake: the add-on as a string of
# the program.
file(READ "${FILE}" text)
string(FIND "${text}" ")keypose_add_on" ends)
if(NOT ends EQUAL -1)
  message(FATAL_ERROR "${FILE} holds the mark that would end its string; choose another in embed_add_on.cmake")
endif()
file(WRITE "${OUTPUT}" "#include \"export/blender/blender_files.h\"\n
namespace keypose::exporting {
namespace {
const char kAddOn[] = R\"keypose_add_on(${text})keypose_add_on\";
}  // namespace

std::string_view BlenderAddOn() { return {kAddOn, sizeof kAddOn - 1}; }
}  // namespace keypose::exporting\n")
