/// What FMI 2.0 and 3.0 share: an instance of a device, with variables by value reference.
///
/// Beside the image, the FMU's resources have a list `variables`, whose lines are the value references 0, 1, ...:
///     hypertuna-fmu 1 KIND SPACE TOKEN       KIND twin or plant, SPACE plane or sea
///     TYPE time
///     TYPE input|fixed|tunable PLACE START   TYPE r, i or b: real, integer, boolean
///     TYPE output COLUMN PLACE FACTOR        a number of a device's column, times the factor
/// Inputs of the twin are in the places of a gait, the fins, `armed`, `steered`, depth and heading; of the plant, of
/// the pulses. Headings are clockwise from north. Parameters are seed, speed, depth, heading, current toward east and
/// north.
///
/// Communication steps have any size. The device makes whole control ticks: after a step, all that have ended by then.
/// A tick takes the inputs that hold when it begins, so that runs do not depend on how steps divide them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "device.h"

namespace hypertuna {

enum class Role { time, input, fixed, tunable, output };

struct Variable {
    char type;
    Role role;
    int place;  // among inputs or parameters, or in a row of all columns
    double start, factor;
};

inline constexpr int fmu_parameters = 6;
inline constexpr double quarter = 1.5707963267948966;  // rad

/// Phase of an instance's life cycle.
enum class Phase : std::uint8_t { instantiated, initializing, stepping, terminated, failed };

class Fmu {
  public:
    using Tell = std::function<void(const std::string&)>;

    /// An instance of the FMU whose resources are in a folder; null where that is refused.
    static std::unique_ptr<Fmu> load(const std::string& folder, const char* token, const Tell& tell) {
        std::unique_ptr<Fmu> made(new Fmu(tell));
        std::string list, image;
        if (!read_file(folder + "/variables", list) || !read_file(folder + "/robot.image", image)) {
            tell("resources: cannot be read in " + folder + "; unpack the FMU whole");
            return nullptr;
        }
        made->image_ = std::move(image);
        if (!made->read_list(list)) {
            tell("resources/variables: is damaged; export the FMU again");
            return nullptr;
        }
        if (!token || made->token_ != token) {
            tell("token: is of another FMU than " + made->token_ + "; import the FMU again");
            return nullptr;
        }
        return made->reset() ? std::move(made) : nullptr;
    }

    Phase phase = Phase::instantiated;

    double tick() const { return ht_device_tick(device_.get()); }
    double time() const { return time_; }  // s, of the last step's end
    void start_at(double start) { time_ = start_ = start; }

    bool get(unsigned reference, char type, double& value) {
        if (!known(reference, type)) return false;
        const Variable& variable = variables_[reference];
        if (variable.role == Role::time)
            value = time();
        else if (variable.role == Role::output)
            value = variable.factor * row_[variable.place];
        else
            value = values_[reference];
        return true;
    }

    bool set(unsigned reference, char type, double value) {
        if (!known(reference, type)) return false;
        const Variable& variable = variables_[reference];
        if (variable.role == Role::time || variable.role == Role::output)
            return refuse("variable " + std::to_string(reference) + ": is an output; set inputs and parameters alone");
        const bool begun = phase != Phase::instantiated && phase != Phase::initializing;
        if (variable.role == Role::fixed && begun)
            return refuse("variable " + std::to_string(reference) + ": is fixed; set it before the first step");
        if (!std::isfinite(value)) return refuse("variable " + std::to_string(reference) + ": must be a finite number");
        if (values_[reference] == value) return true;
        values_[reference] = value;
        return begun || variable.role == Role::input || create();
    }

    /// Make a communication step; false, with a sentence, where the step is refused or the plant diverges.
    bool step(double at, double size) {
        if (phase != Phase::stepping) return refuse("step: the instance is not initialized, or failed; reset it");
        if (!(0 < size && size <= 1e9 * tick()))
            return refuse("step: is " + written(size) + " s, but must be above 0 and at most " + written(1e9 * tick()) +
                          " s");
        if (!(std::abs(at - time_) <= slack * tick()))
            return refuse("step: begins at " + written(at) + " s, but the last one ended at " + written(time_) + " s");
        const int wanted = std::max(0, int(ticks_by(at + size) - ticks_));
        int made = 0;
        const bool under_way = start_ + tick() * (double(ticks_) + slack) < at;
        if (under_way && wanted > 0) made = ht_device_advance(device_.get(), 1);  // by the inputs that it began with
        if (!under_way || wanted > 0) send(values_);
        made += ht_device_advance(device_.get(), wanted - made);
        ticks_ += std::uint64_t(made);
        time_ = at + size;
        ht_device_read(device_.get(), row_.data());
        if (made == wanted) return true;
        phase = Phase::failed, time_ = start_ + tick() * double(ticks_);
        return refuse("step: the run diverged at " + written(time_) + " s; reset the instance");
    }

    /// As created, with the start values of the description.
    bool reset() {
        phase = Phase::instantiated;
        start_at(0);
        for (std::size_t k = 0; k < variables_.size(); ++k) values_[k] = variables_[k].start;
        return create();
    }

    std::size_t state_size() const {
        return token_.size() + sizeof(Head) + 2 * values_.size() * sizeof(double) + ht_device_state_size(device_.get());
    }
    void save(unsigned char* to) const {
        const Head head{start_, time_, ticks_, phase};
        to = put(to, token_.data(), token_.size());
        to = put(to, &head, sizeof(head));
        for (const auto* values : {&values_, &sent_}) to = put(to, values->data(), values->size() * sizeof(double));
        ht_device_save(device_.get(), to);
    }
    bool restore(const unsigned char* from, std::size_t size) {
        if (size != state_size() || std::memcmp(from, token_.data(), token_.size()) != 0)
            return refuse("state: is not of this FMU");
        from += token_.size();
        Head head;
        std::vector<double> values(values_.size()), sent(values_.size());
        std::memcpy(&head, from, sizeof(head));
        from += sizeof(head);
        for (auto* read : {&values, &sent}) {
            std::memcpy(read->data(), from, read->size() * sizeof(double));
            from += read->size() * sizeof(double);
        }
        values_.swap(values);
        bool same = true;  // parameters that the device was created with
        for (std::size_t k = 0; k < values.size(); ++k)
            same = same && (variables_[k].role == Role::input || values[k] == values_[k]);
        if (!same && !create()) return false;
        start_ = head.start, time_ = head.time, ticks_ = head.ticks, phase = head.phase;
        if (!ht_device_restore(device_.get(), from, ht_device_state_size(device_.get())))
            return refuse("state: is not of this FMU");
        send(sent);  // which a tick under way began with
        ht_device_read(device_.get(), row_.data());
        return true;
    }

    /// Log what is wrong; return false.
    bool refuse(const std::string& sentence) const {
        tell_(sentence);
        return false;
    }

  private:
    static constexpr double slack = 1e-3;  // of a tick, for rounded times of importers

    struct Head {
        double start, time;
        std::uint64_t ticks;
        Phase phase;
    };

    explicit Fmu(const Tell& tell) : tell_(tell), device_(nullptr, ht_device_free) {}

    static unsigned char* put(unsigned char* to, const void* from, std::size_t size) {
        std::memcpy(to, from, size);
        return to + size;
    }
    static std::string written(double number) {
        char text[32];
        std::snprintf(text, sizeof(text), "%.9g", number);
        return text;
    }
    static bool read_file(const std::string& path, std::string& content) {
        std::FILE* const file = std::fopen(path.c_str(), "rb");
        if (!file) return false;
        char part[4096];
        while (const std::size_t size = std::fread(part, 1, sizeof(part), file)) content.append(part, size);
        return std::fclose(file) == 0;
    }

    /// Read the list of variables; the places of outputs are found once there is a device.
    bool read_list(const std::string& list) {
        char kind[8], space[8], token[64], type, role[8], name[48];
        int used = 0;
        const char* at = list.c_str();
        if (std::sscanf(at, "hypertuna-fmu 1 %7s %7s %63s\n%n", kind, space, token, &used) != 3) return false;
        plant_ = std::string(kind) == "plant", sea_ = std::string(space) == "sea", token_ = token;
        for (at += used; *at; at += used) {
            Variable read{'r', Role::time, 0, 0, 1};
            if (std::sscanf(at, "%c %7s%n", &type, role, &used) != 2) return false;
            at += used, read.type = type, used = 0;
            const std::string what = role;
            if (what == "output") {
                if (std::sscanf(at, "%47s %d %lf%n", name, &read.place, &read.factor, &used) != 3) return false;
                names_.push_back(name), read.role = Role::output;
            } else if (what != "time") {
                if (std::sscanf(at, "%d %lf%n", &read.place, &read.start, &used) != 2) return false;
                read.role = what == "input" ? Role::input : what == "fixed" ? Role::fixed : Role::tunable;
            }
            while (at[used] == '\n') ++used;
            variables_.push_back(read);
        }
        values_.resize(variables_.size());
        return true;
    }

    /// Make the device anew, from the parameters.
    bool create() {
        double given[fmu_parameters] = {};
        for (std::size_t k = 0; k < variables_.size(); ++k)
            if (parameter(variables_[k].role)) given[variables_[k].place] = values_[k];
        const auto [seed, speed, depth, heading, east, north] = given;
        const ht_start start{sea_, std::uint64_t(seed), speed, depth, quarter - heading, {east, north}, HUGE_VAL};
        char fault[512];
        const auto* bytes = reinterpret_cast<const unsigned char*>(image_.data());
        device_.reset(ht_device_create(bytes, image_.size(), &start, plant_, fault, sizeof(fault)));
        if (!device_) return refuse(fault);
        ticks_ = 0, sent_ = values_;
        return find_outputs();
    }

    /// Find the places of the outputs in a row.
    bool find_outputs() {
        std::size_t next = 0;
        int size = 0, width;
        for (int k = 0; ht_device_column(device_.get(), k, &width); ++k) size += width;
        row_.resize(std::size_t(size));
        for (Variable& variable : variables_) {
            if (names_.empty() || variable.role != Role::output) continue;
            const std::string& name = names_[next++];
            const char* column;
            int begin = 0;
            for (int k = 0; (column = ht_device_column(device_.get(), k, &width)) && column != name; ++k)
                begin += width;
            if (!column || variable.place < 0 || width <= variable.place)
                return refuse("resources/variables: has an output " + name + " that the twin lacks");
            variable.place += begin;
        }
        names_.clear();
        ht_device_read(device_.get(), row_.data());
        return true;
    }

    /// Ticks that have ended by a time.
    std::uint64_t ticks_by(double time) const { return std::uint64_t((time - start_) / tick() + slack); }

    /// Give the device its inputs and tunable parameters.
    void send(const std::vector<double>& values) {
        sent_ = values;
        const int joints = ht_device_joints(device_.get());
        std::vector<double> inputs(std::size_t(3 * joints + 7));
        double current[2] = {};
        for (std::size_t k = 0; k < variables_.size(); ++k) {
            const Variable& variable = variables_[k];
            if (variable.role == Role::input) inputs[variable.place] = values[k];
            if (variable.role == Role::tunable && variable.place >= 4) current[variable.place - 4] = values[k];
        }
        const double* const after = &inputs[std::size_t(1 + 3 * joints)];  // the gait
        if (plant_)
            ht_device_drive(device_.get(), inputs.data());
        else
            ht_device_command(device_.get(), inputs.data(), after, after[2] != 0);
        ht_device_steer(device_.get(), after[3] != 0, after[4], quarter - after[5]);
        ht_device_flow(device_.get(), current);
    }

    static bool parameter(Role role) { return role == Role::fixed || role == Role::tunable; }
    bool known(unsigned reference, char type) const {
        if (reference < variables_.size() && variables_[reference].type == type) return true;
        return refuse("variable " + std::to_string(reference) + ": there is none of this type");
    }

    Tell tell_;
    std::string image_, token_;
    bool plant_ = false, sea_ = false;
    std::vector<Variable> variables_;
    std::vector<std::string> names_;           // of the outputs' columns, until they are found
    std::vector<double> values_, sent_, row_;  // of variables, as sent to the device; of outputs
    std::unique_ptr<ht_device, void (*)(ht_device*)> device_;
    double start_ = 0, time_ = 0;  // s
    std::uint64_t ticks_ = 0;
};

// --- functions of the standard that both versions have

enum FmiStatus { ok, warning, discard, error };
using Reference = std::uint32_t;
using State = std::vector<unsigned char>;

inline Fmu& of(void* instance) { return *static_cast<Fmu*>(instance); }
inline FmiStatus good(bool done) { return done ? ok : error; }
inline FmiStatus missing(void* instance) { return good(of(instance).refuse("call: is not one that this FMU has")); }

template <class T>
FmiStatus get(void* instance, const Reference* references, std::size_t count, char type, T* values) {
    for (std::size_t k = 0; k < count; ++k) {
        double value = 0;
        if (!of(instance).get(references[k], type, value)) return error;
        values[k] = T(value);
    }
    return ok;
}
template <class T>
FmiStatus set(void* instance, const Reference* references, std::size_t count, char type, const T* values) {
    for (std::size_t k = 0; k < count; ++k)
        if (!of(instance).set(references[k], type, double(values[k]))) return error;
    return ok;
}

inline FmiStatus get_state(void* instance, void** state) {
    State* const to = *state ? static_cast<State*>(*state) : new State;
    to->resize(of(instance).state_size());
    of(instance).save(to->data());
    *state = to;
    return ok;
}
inline FmiStatus set_state(void* instance, void* state) {
    const State& from = *static_cast<State*>(state);
    return good(of(instance).restore(from.data(), from.size()));
}
inline FmiStatus free_state(void** state) {
    delete static_cast<State*>(*state);
    *state = nullptr;
    return ok;
}
inline FmiStatus serialized_size(void* state, std::size_t* size) {
    *size = static_cast<State*>(state)->size();
    return ok;
}
inline FmiStatus serialize(void* instance, void* state, unsigned char* bytes, std::size_t size) {
    const State& from = *static_cast<State*>(state);
    if (size < from.size()) return good(of(instance).refuse("state: has more bytes than there is room for"));
    std::memcpy(bytes, from.data(), from.size());
    return ok;
}
inline FmiStatus deserialize(const unsigned char* bytes, std::size_t size, void** state) {
    *state = new State(bytes, bytes + size);
    return ok;
}

inline FmiStatus go_to(void* instance, Phase phase) {
    of(instance).phase = phase;
    return ok;
}

/// The functions of an instance's life and of its states, whose names differ between versions of the standard.
#define COMMON(API, fmi, State, Deserialize)                                                                          \
    API void fmi##FreeInstance(void* c) { delete static_cast<Fmu*>(c); }                                              \
    API int fmi##ExitInitializationMode(void* c) { return go_to(c, Phase::stepping); }                                \
    API int fmi##Terminate(void* c) { return go_to(c, Phase::terminated); }                                           \
    API int fmi##Reset(void* c) { return good(of(c).reset()); }                                                       \
    API int fmi##GetFMU##State(void* c, void** state) { return get_state(c, state); }                                 \
    API int fmi##SetFMU##State(void* c, void* state) { return set_state(c, state); }                                  \
    API int fmi##FreeFMU##State(void*, void** state) { return free_state(state); }                                    \
    API int fmi##SerializedFMU##State##Size(void*, void* state, std::size_t* n) { return serialized_size(state, n); } \
    API int fmi##SerializeFMU##State(void* c, void* state, unsigned char* bytes, std::size_t n) {                     \
        return serialize(c, state, bytes, n);                                                                         \
    }                                                                                                                 \
    API int fmi##Deserialize##FMU##State(void*, const unsigned char* bytes, std::size_t n, void** state) {            \
        return deserialize(bytes, n, state);                                                                          \
    }

}  // namespace hypertuna
