/// The resources of an FMU: a robot's image, and a list of variables. Anyone may have changed either file: each has a
/// largest size, and the reader takes nothing in the list for granted.
///
/// The lines of the list `variables` are the value references 0, 1, ...:
///     hypertuna-fmu 1 KIND SPACE TOKEN       KIND twin or plant, SPACE plane or sea
///     TYPE time
///     TYPE input|fixed|tunable PLACE START   TYPE r, i or b: real, integer, boolean
///     TYPE output COLUMN PLACE FACTOR        a number of a device's column, times the factor
/// The places of the twin's inputs are those of a gait, the fins, `armed`, `steered`, depth and heading; the places of
/// the plant's inputs are those of the pulses. Headings are clockwise from north. Parameters are seed, speed, depth,
/// heading, current toward east and north.
#pragma once

#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace hypertuna {

enum class Role { time, input, fixed, tunable, output };

struct Variable {
    char type;
    Role role;
    int place;  // among inputs or parameters, or in a row of all columns
    double start, factor;
};

inline constexpr int
    fmu_parameters = 6,
    fixed_parameters = 4;  // number of all parameters; of the first ones, which are fixed, while the others are tunable
inline constexpr long long largest_list = 1 << 20, largest_image = 1 << 24;  // bytes

struct FmuList {
    bool plant = false, sea = false;
    std::string token;
    std::vector<Variable> variables;
    std::vector<std::string> names;  // columns of the outputs
};

/// Read a regular file of a largest size [bytes]; false where there is none.
inline bool read_file(const std::string& path, long long largest, std::string& content) {
    struct stat about;
    const bool regular = stat(path.c_str(), &about) == 0 && (about.st_mode & S_IFMT) == S_IFREG;
    std::FILE* const file = regular && about.st_size <= largest ? std::fopen(path.c_str(), "rb") : nullptr;
    if (!file) return false;
    content.resize(std::size_t(about.st_size));
    content.resize(std::fread(content.data(), 1, content.size(), file));
    std::fclose(file);
    return true;
}

/// Read a number, independent of the number format of the importer's language.
template <class T>
bool parsed(std::string_view word, T& number) {
    const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), number);
    return fault == std::errc() && end == word.data() + word.size();
}

inline bool read_head(const std::vector<std::string_view>& words, FmuList& list) {
    if (words.size() != 5 || words[0] != "hypertuna-fmu" || words[1] != "1" || words[4].empty()) return false;
    list.plant = words[2] == "plant", list.sea = words[3] == "sea", list.token = words[4];
    return (list.plant || words[2] == "twin") && (list.sea || words[3] == "plane");
}

inline bool read_variable(const std::vector<std::string_view>& words, FmuList& list) {
    static constexpr std::string_view roles[] = {"time", "input", "fixed", "tunable", "output"};
    static constexpr std::size_t widths[] = {2, 4, 4, 4, 5};
    if (words.size() < 2) return false;
    const std::size_t role = std::size_t(std::find(roles, std::end(roles), words[1]) - roles);
    if (role == std::size(roles) || words.size() != widths[role]) return false;
    if (words[0] != "r" && words[0] != "i" && words[0] != "b") return false;
    Variable read{words[0][0], Role(role), 0, 0, 1};
    if (read.role == Role::output) list.names.emplace_back(words[2]);
    if (read.role != Role::time) {
        double& number = read.role == Role::output ? read.factor : read.start;
        if (!parsed(words[words.size() - 2], read.place) || !parsed(words.back(), number) || !std::isfinite(number))
            return false;
        const bool fixed = read.role == Role::fixed, parameter = fixed || read.role == Role::tunable;
        if (read.place < (read.role == Role::tunable ? fixed_parameters : 0) ||
            (parameter && (fixed ? fixed_parameters : fmu_parameters) <= read.place))
            return false;
    }
    list.variables.push_back(read);
    return true;
}

/// Read the list of variables; whether the robot has its inputs and outputs is checked later, on the device. Returns
/// the number of the first wrong line, from 1; 0 if all are right.
inline std::size_t read_list(std::string_view text, FmuList& list) {
    for (std::size_t line = 1; line == 1 || !text.empty(); ++line) {
        std::string_view left = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(left.size() + 1, text.size()));
        std::vector<std::string_view> words;
        for (bool more = true; more;) {
            const std::size_t end = left.find(' ');
            words.push_back(left.substr(0, end));
            more = end != left.npos;
            left.remove_prefix(more ? end + 1 : left.size());
        }
        if (!(line == 1 ? read_head(words, list) : read_variable(words, list))) return line;
    }
    return 0;
}

}  // namespace hypertuna
