/// Vehicle: the state on board, and the parameters.
#pragma once

#include "app/vehicle/black_box.hpp"
#include "app/vehicle/mission_check.hpp"
#include "app/vehicle/states.hpp"
#include "app/vehicle/store.hpp"
#include "app/vehicle/supervisor.hpp"

namespace hypertuna::firmware {

inline constexpr int key_size = 32;
inline constexpr float max_origin_distance =
    2e4f;  // m: a stored mission farther from its origin belongs to another water

/// Sectors of the flash memory: two each for the parameters, a mission, the timestamp of signatures and the key; one
/// that proves that there once was a key; two for the surface.
enum Sector : int {
    parameter_sector = 0,
    mission_sector = 2,
    stamp_sector = 4,
    key_sector = 6,
    witness_sector = 8,
    surface_sector = 9
};
inline constexpr int flash_sectors = 11;
inline constexpr std::uint32_t stamp_layout = 0x73746d02, key_layout = 0x6b657901, surface_layout = 0x73757201;
static_assert(piece + int(sizeof(StoredMission)) <= flash_sector && piece + 4 * max_parameters <= flash_sector);

struct StoredKey {
    std::uint32_t present;  // 0: there is no key
    std::uint8_t key[key_size];
};
inline constexpr float detour_radius = 3.0f;    // m, radius of home without a mission
inline constexpr float depth_error_max = 0.5f;  // m: largest height above the surface that the depth may show by error
inline constexpr float stick_band = 0.05f;      // part of an axis within which its deflection is noise

/// The vehicle's public state at the end of the last tick.
struct Snapshot {
    std::uint32_t tick;
    float time;  // s since boot
    PilotReadings<float> readings;
    ControllerOutput<float> output;
    Command<float> command;
    Estimate<float> estimate;
    Mode mode;        // mode of the pilot
    Reasons reasons;  // reasons of the pilot
    int leg;          // current waypoint
    State state;
    Faults faults;
    Answer answer;
    float battery_left;  // fraction of the charge, 0 to 1
    float load;          // CPU time of the last tick as a fraction of the tick

    constexpr bool armed() const { return state != State::disarmed; }
};

/// Duration of a tick's parts [counts of the board's clock].
struct Profile {
    std::uint32_t controller, pilot, whole, radio;  // the radio's part precedes the vehicle's
};

/// The satellite receiver's last fix.
struct LastFix {
    std::int32_t place[2];  // latitude and longitude [1e-7 deg]
    std::int32_t accuracy;  // standard deviation [mm]; 0 unknown
    std::uint32_t tick;
    std::uint8_t satellites;  // 0 unknown
    bool any;                 // there was a fix since boot
};

/// Progress of the mission on board: the last current waypoint, and how many of those before it were reached or passed.
struct Progress {
    int leg, reached, passed;
};

struct Vehicle {
    const Description* robot;
    float value[max_parameters];
    Model model;
    Raw raw;
    LastFix fix;
    PilotState<float> state;
    SupervisorState memory;
    std::uint8_t stored[4 * max_parameters];  // parameters
    StoredMission plan;
    std::uint64_t stamp;  // timestamp of signatures: later than every verified one
    StoredKey secret;
    float surface;  // m that the depth sensor showed at the surface, when the robot was disarmed and heard the ground
    Store store, missions, stamps, keys, surfaces;
    bool locked, witnessed;  // a stored key cannot be read, so that no command is accepted; the witnesses are complete
    BlackBox box;
    Snapshot now;
    Profile profile;
    Station pilot;           // station in control: it armed the robot or took control since; none while disarmed
    State before;            // state to which `held` returns
    Mission<float> mission;  // mission on board
    bool has_mission;        // whether there is one
    bool way_home;           // mission or fence were uploaded, or begun, since boot: they belong to this water
    bool has_home;           // the mission says where home is
    PlanNumbers numbers;     // numbers of the mission and the fence on board
    int leg;                 // waypoint at which the mission begins or resumes
    Progress progress;       // progress of the mission when it was flown last
    Mission<float> detour;   // flown in place of the mission: an ascent, or home without a mission
    bool on_detour;
    Place home;                     // home without a mission that has one: place of arming, or of an order [m]
    bool home_set;                  // home was set by an order, which arming does not change
    int agreed;                     // ticks for which fixes have agreed, until home is known
    bool recalled;                  // the present call home was followed
    std::uint32_t ascent_deadline;  // tick at which the ascent has failed
    bool ascent_failed;             // the ascent failed, and is not repeated
    Origin origin;
    bool unplaced;                  // the origin was given, and no fix has placed the robot yet
    bool fixed;                     // a fix came since boot
    Command<float> requested;       // command of the station in control
    bool centered;                  // the sticks were centered since the state became `manual`
    std::uint32_t requested_at;     // tick of `requested`
    std::uint32_t silence;          // ticks without the ground, where it could be received
    bool defaults, watchdog_reset;  // no stored parameters; booted by the watchdog
    bool was_armed;                 // the robot was armed before a restart that left the kept word
    int submerged;                  // ticks after boot for which the depth was not that of the surface
    std::uint32_t started;          // count of the clock at the start of the last tick
    float steps_behind;             // ticks of control that the clock is ahead of those made
    std::uint32_t writing;          // counts of the clock that the flash memory took in the last tick
    std::uint32_t late_until;       // tick until which a late tick is reported
    std::uint32_t lost;             // records lost before the last tick
};

inline const Snapshot& snapshot(const Vehicle& vehicle) { return vehicle.now; }

/// Whether a mission or a fence is on board: its coordinates count from the origin.
inline bool has_plan(const Vehicle& vehicle) {
    return vehicle.has_mission || 0 < vehicle.mission.corners || 0.0f < vehicle.mission.range;
}

/// Estimated place of the robot.
inline Place here(const Vehicle& vehicle) { return {vehicle.now.estimate.x, vehicle.now.estimate.y}; }

/// Whether a restart lost the robot's place: the origin is that of the stored mission, and no fix has come since.
inline bool is_place_lost(const Vehicle& vehicle) { return vehicle.unplaced && has_plan(vehicle) && !vehicle.way_home; }

/// Whether the robot's place on the map is known, at least by what the ground said.
inline bool is_placed(const Vehicle& vehicle) { return vehicle.origin.known && !is_place_lost(vehicle); }

/// Home of a mission without one of its own: before arming, where the robot is.
inline Place own_home(const Vehicle& vehicle) {
    return vehicle.now.armed() || vehicle.home_set ? vehicle.home : here(vehicle);
}
inline Place home_of(const Vehicle& vehicle) { return vehicle.has_home ? vehicle.mission.home : own_home(vehicle); }

/// Whether a station is in control: any station while the robot is disarmed, or ascends by itself after a restart.
inline bool in_control(const Vehicle& vehicle, Station station) {
    return vehicle.pilot == Station{} || station == vehicle.pilot;
}

/// Called for every valid frame of a ground station: only the one in control holds off the loss of the link.
inline void on_ground_contact(Vehicle& vehicle, Station from) {
    if (in_control(vehicle, from)) vehicle.silence = 0;
}

inline const Origin& origin(const Vehicle& vehicle) { return vehicle.origin; }
inline const Mission<float>& mission(const Vehicle& vehicle) { return vehicle.mission; }
inline const Pilot<float>* pilot(const Vehicle& vehicle) { return &vehicle.model.pilot; }
inline const Limits& limits(const Vehicle& vehicle) { return vehicle.model.limits; }

// --- parameters

inline int parameter_count(const Vehicle& vehicle) { return vehicle.robot->parameters; }
inline const ParameterInfo& parameter(const Vehicle& vehicle, int k) { return vehicle.robot->parameter[k]; }
inline float value(const Vehicle& vehicle, int k) { return vehicle.value[k]; }

/// Key that signs commands; nullptr if there is none.
inline const std::uint8_t* key(const Vehicle& vehicle) {
    return vehicle.secret.present != 0 ? vehicle.secret.key : nullptr;
}

}  // namespace hypertuna::firmware
