/// What FMI 2.0 and 3.0 share: an instance of a device, with variables by value reference.
///
/// Communication steps have any size. The device makes whole control ticks: after a step, all that have ended by then.
/// A tick takes the inputs that hold when it begins, so that a run does not depend on how it is divided into steps.
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
#include "fmu_resources.hpp"

namespace hypertuna {

inline constexpr double quarter = 1.5707963267948966;     // rad
inline constexpr double largest_seed = 9007199254740992;  // 2^53, up to which a double holds all whole numbers

/// Phase of an instance's life cycle.
enum class Phase : std::uint8_t { instantiated, initializing, stepping, terminated, failed };

class Fmu {
  public:
    using Tell = std::function<void(const std::string&)>;

    /// Make an instance of the FMU whose resources are in a folder; null where that is refused.
    static std::unique_ptr<Fmu> load(const std::string& folder, const char* token, const Tell& tell) {
        std::unique_ptr<Fmu> made(new Fmu(tell));
        std::string text;
        if (!made->read(folder + "/variables", largest_list, text) ||
            !made->read(folder + "/robot.image", largest_image, made->image_))
            return nullptr;
        if (const std::size_t line = read_list(text, made->list_)) {
            made->refuse_line(line, "cannot be read");
            return nullptr;
        }
        made->values_.resize(made->variables_.size());
        if (!token || made->list_.token != token) {
            tell("token: is of another FMU than " + made->list_.token + "; import the FMU again");
            return nullptr;
        }
        return made->reset() ? std::move(made) : nullptr;
    }

    Phase phase = Phase::instantiated;

    double tick() const { return ht_device_tick(device_.get()); }
    double time() const { return time_; }  // s, of the last step's end
    void start_at(double start) { time_ = start_ = start; }

    bool get(unsigned reference, char type, double& value) {
        if (!check_variable(reference, type)) return false;
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
        if (!check_variable(reference, type)) return false;
        const Variable& variable = variables_[reference];
        if (variable.role == Role::time || variable.role == Role::output)
            return refuse("variable " + std::to_string(reference) + ": is an output; set inputs and parameters alone");
        const bool begun = phase != Phase::instantiated && phase != Phase::initializing;
        if (variable.role == Role::fixed && begun)
            return refuse("variable " + std::to_string(reference) + ": is fixed; set it before the first step");
        if (!std::isfinite(value)) return refuse("variable " + std::to_string(reference) + ": must be a finite number");
        const double before = values_[reference];
        values_[reference] = value;
        if (before == value || begun || variable.role == Role::input || create()) return true;
        values_[reference] = before;
        return false;
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
        if (under_way && wanted > 0)
            made = ht_device_advance(device_.get(), 1);  // the tick under way keeps the inputs that it began with
        if (!under_way || wanted > 0) send(values_);
        made += ht_device_advance(device_.get(), wanted - made);
        ticks_ += std::uint64_t(made);
        time_ = at + size;
        ht_device_read(device_.get(), row_.data());
        if (made == wanted) return true;
        phase = Phase::failed, time_ = start_ + tick() * double(ticks_);
        return refuse("step: the run diverged at " + written(time_) + " s; reset the instance");
    }

    /// Return to the state after creation, with the start values of the description.
    bool reset() {
        phase = Phase::instantiated;
        start_at(0);
        for (std::size_t k = 0; k < variables_.size(); ++k) values_[k] = variables_[k].start;
        return create();
    }

    std::size_t state_size() const {
        return list_.token.size() + sizeof(Head) + 2 * values_.size() * sizeof(double) +
               ht_device_state_size(device_.get());
    }
    void save(unsigned char* to) const {
        const Head head{start_, time_, ticks_, phase};
        to = put(to, list_.token.data(), list_.token.size());
        to = put(to, &head, sizeof(head));
        for (const auto* values : {&values_, &sent_}) to = put(to, values->data(), values->size() * sizeof(double));
        ht_device_save(device_.get(), to);
    }
    bool restore(const unsigned char* from, std::size_t size) {
        if (size != state_size() || std::memcmp(from, list_.token.data(), list_.token.size()) != 0)
            return refuse("state: is not of this FMU");
        from += list_.token.size();
        Head head;
        std::vector<double> values(values_.size()), sent(values_.size());
        std::memcpy(&head, from, sizeof(head));
        from += sizeof(head);
        for (auto* read : {&values, &sent}) {
            std::memcpy(read->data(), from, read->size() * sizeof(double));
            from += read->size() * sizeof(double);
        }
        values_.swap(values);
        bool same = true;  // whether the device was created with these parameters
        for (std::size_t k = 0; k < values.size(); ++k)
            same = same && (variables_[k].role == Role::input || values[k] == values_[k]);
        if (!same && !create()) return false;
        start_ = head.start, time_ = head.time, ticks_ = head.ticks, phase = head.phase;
        if (!ht_device_restore(device_.get(), from, ht_device_state_size(device_.get())))
            return refuse("state: is not of this FMU");
        send(sent);  // the inputs that a tick under way began with
        ht_device_read(device_.get(), row_.data());
        return true;
    }

    /// Log what is wrong; return false.
    bool refuse(const std::string& sentence) const {
        tell_(sentence);
        return false;
    }

  private:
    static constexpr double slack = 1e-3;  // part of a tick, a tolerance for rounded times of importers

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
    bool read(const std::string& path, long long largest, std::string& content) const {
        return read_file(path, largest, content) ||
               refuse("resources: " + path + " must be a readable file of at most " + written(double(largest)) +
                      " bytes; unpack the FMU whole, or export it again");
    }
    bool refuse_line(std::size_t line, const char* what) const {
        return refuse("resources/variables, line " + std::to_string(line) + ": " + what + "; export the FMU again");
    }

    /// Make the device anew, from the parameters.
    bool create() {
        double given[fmu_parameters] = {};
        for (std::size_t k = 0; k < variables_.size(); ++k) {
            const Variable& variable = variables_[k];
            if (variable.role == Role::fixed || variable.role == Role::tunable) given[variable.place] = values_[k];
        }
        const auto [seed, speed, depth, heading, east, north] = given;
        if (!(0 <= seed && seed <= largest_seed))
            return refuse("seed: must be from 0 to 2^53, but is " + written(seed));
        const ht_start start{list_.sea, std::uint64_t(seed), speed, depth, quarter - heading, {east, north}, HUGE_VAL};
        char fault[512];
        const auto* bytes = reinterpret_cast<const unsigned char*>(image_.data());
        device_.reset(ht_device_create(bytes, image_.size(), &start, list_.plant, fault, sizeof(fault)));
        if (!device_) return refuse(fault);
        ticks_ = 0, sent_ = values_;
        return find_places();
    }

    /// Check the places of inputs, and find those of the outputs in a row.
    bool find_places() {
        std::size_t next = 0;
        int size = 0, width;
        for (int k = 0; ht_device_column(device_.get(), k, &width); ++k) size += width;
        row_.resize(std::size_t(size));
        for (std::size_t v = 0; v < variables_.size(); ++v) {
            Variable& variable = variables_[v];
            if (variable.role == Role::input && (variable.place < 0 || inputs() <= variable.place))
                return refuse_line(v + 2, "the robot has no such input");
            if (names_.empty() || variable.role != Role::output) continue;
            const std::string& name = names_[next++];
            const char* column;
            int begin = 0;
            for (int k = 0; (column = ht_device_column(device_.get(), k, &width)) && column != name; ++k)
                begin += width;
            if (!column || variable.place < 0 || width <= variable.place)
                return refuse_line(v + 2, "the robot has no such output");
            variable.place += begin;
        }
        names_.clear();
        ht_device_read(device_.get(), row_.data());
        return true;
    }
    /// Number of inputs: a gait, the fins, `armed`, `steered`, depth and heading; or the pulses, which are fewer.
    int inputs() const { return list_.plant ? 2 * joints() + 2 : 3 * joints() + 7; }
    int joints() const { return ht_device_joints(device_.get()); }

    /// Ticks that have ended by a time.
    std::uint64_t ticks_by(double time) const { return std::uint64_t((time - start_) / tick() + slack); }

    /// Give the device its inputs and tunable parameters.
    void send(const std::vector<double>& values) {
        sent_ = values;
        const int joints = this->joints();
        std::vector<double> inputs(std::size_t(3 * joints + 7));
        double current[2] = {};
        for (std::size_t k = 0; k < variables_.size(); ++k) {
            const Variable& variable = variables_[k];
            if (variable.role == Role::input) inputs[variable.place] = values[k];
            if (variable.role == Role::tunable) current[variable.place - fixed_parameters] = values[k];
        }
        const double* const after = &inputs[std::size_t(1 + 3 * joints)];  // inputs after the gait
        if (list_.plant)
            ht_device_drive(device_.get(), inputs.data());
        else
            ht_device_command(device_.get(), inputs.data(), after, after[2] != 0);
        ht_device_steer(device_.get(), after[3] != 0, after[4], quarter - after[5]);
        ht_device_flow(device_.get(), current);
    }

    bool check_variable(unsigned reference, char type) const {
        if (reference < variables_.size() && variables_[reference].type == type) return true;
        return refuse("variable " + std::to_string(reference) + ": there is none of this type");
    }

    Tell tell_;
    std::string image_;
    FmuList list_;
    std::vector<Variable>& variables_ = list_.variables;
    std::vector<std::string>& names_ = list_.names;  // names of the outputs, until their columns are found
    std::vector<double> values_, sent_,
        row_;  // values of the variables; those last sent to the device; outputs of the device
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
        if (std::is_integral_v<T> && !(std::abs(value) <= INT32_MAX)) value = 0;  // holds no such number
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
