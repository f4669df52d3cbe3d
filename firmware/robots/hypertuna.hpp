/// hypertuna: written by `hypertuna firmware params` from its description. Do not edit.
#pragma once

#include "app/vehicle/parameters.hpp"

// clang-format off
namespace hypertuna::firmware::robot {

inline constexpr float values[] = {
    0.01f,  // controller tick[0]
    0.8187308f,  // controller relax[0]
    0.9048374f,  // controller couple[0]
    0.15813f,  // controller smoothing_rate[0]
    0.8537388f,  // controller smoothing_decay[0]
    0.7f,  // controller learning[0]
    0.25f,  // controller missing[0]
    0.1f,  // controller limited[0]
    0.05f,  // controller moving[0]
    0.05235988f,  // controller amplitude_min[0]
    0.0f,  // controller direct[0]
    0.3811799f,  // controller reach[0]
    0.31764993f,  // controller amplitude[0]
    1.5708f,  // controller bend_range[0]
    0.31933653f,  // controller bend_step[0]
    3.3901567f,  // controller safe_static[0]
    0.2782882f,  // controller safe_rate[0]
    4.4173307f,  // controller safe_square[0]
    0.0f,  // controller direct[1]
    0.65345126f,  // controller reach[1]
    0.54454273f,  // controller amplitude[1]
    1.5708f,  // controller bend_range[1]
    0.54743403f,  // controller bend_step[1]
    2.0624087f,  // controller safe_static[1]
    0.18228951f,  // controller safe_rate[1]
    3.0374575f,  // controller safe_square[1]
    -0.19821355f,  // controller map_low[0]
    0.19821355f,  // controller map_high[0]
    0.40777695f,  // controller map[0]
    -0.5611377f,  // controller map[1]
    -0.30046824f,  // controller map[2]
    0.28427202f,  // controller map[3]
    0.9725682f,  // controller map[4]
    0.4109508f,  // controller map[5]
    7.5f,  // controller servo_speed[0]
    804864.94f,  // controller servo_stall[0]
    60000.0f,  // controller fill[0]
    2.5105754e-07f,  // controller compliance[0]
    -0.19821355f,  // controller map_low[1]
    0.19821355f,  // controller map_high[1]
    0.40777695f,  // controller map[6]
    -0.5611377f,  // controller map[7]
    -0.30046824f,  // controller map[8]
    0.28427202f,  // controller map[9]
    0.9725682f,  // controller map[10]
    0.4109508f,  // controller map[11]
    7.5f,  // controller servo_speed[1]
    804864.94f,  // controller servo_stall[1]
    60000.0f,  // controller fill[1]
    2.5105754e-07f,  // controller compliance[1]
    -0.37900174f,  // controller map_low[2]
    0.37900174f,  // controller map_high[2]
    0.14362517f,  // controller map[12]
    -0.14768995f,  // controller map[13]
    -0.05550814f,  // controller map[14]
    0.056010593f,  // controller map[15]
    0.27189153f,  // controller map[16]
    0.31619674f,  // controller map[17]
    7.5f,  // controller servo_speed[2]
    804864.94f,  // controller servo_stall[2]
    60000.0f,  // controller fill[2]
    1.3290689e-07f,  // controller compliance[2]
    -0.37900174f,  // controller map_low[3]
    0.37900174f,  // controller map_high[3]
    0.14362517f,  // controller map[18]
    -0.14768995f,  // controller map[19]
    -0.05550814f,  // controller map[20]
    0.056010593f,  // controller map[21]
    0.27189153f,  // controller map[22]
    0.31619674f,  // controller map[23]
    7.5f,  // controller servo_speed[3]
    804864.94f,  // controller servo_stall[3]
    60000.0f,  // controller fill[3]
    1.3290689e-07f,  // controller compliance[3]
    250000.0f,  // controller pressure_soft[0]
    300000.0f,  // controller pressure_hard[0]
    -100000.0f,  // controller pressure_low[0]
    500000.0f,  // controller pressure_high[0]
    200000.0f,  // controller pressure_step[0]
    -5.0f,  // controller current_low[0]
    5.0f,  // controller current_high[0]
    34.9f,  // controller rate_high[0]
    157.0f,  // controller acceleration_high[0]
    7.4f,  // controller voltage_rated[0]
    12.8f,  // controller voltage_low[0]
    0.0f,  // controller voltage_min[0]
    20.0f,  // controller voltage_max[0]
    8.0f,  // controller frequency_max[0]
    0.7853982f,  // controller fin_max[0]
    50.0f,  // controller timeout[0]
    0.0015f,  // controller pulse_center[0]
    0.000637f,  // controller pulse_per_rad[0]
    0.0008f,  // controller pulse_min[0]
    0.0022f,  // controller pulse_max[0]
    0.15f,  // controller slew[0]
    10.0f,  // pilot every[0]
    0.01f,  // pilot tick[0]
    0.2f,  // pilot gravity_rate[0]
    0.2f,  // pilot field_rate[0]
    0.017453292f,  // pilot drift_max[0]
    34.9f,  // pilot rate_max[0]
    157.0f,  // pilot acceleration_max[0]
    0.5f,  // pilot field_low[0]
    1.5f,  // pilot field_high[0]
    1.5f,  // pilot depth_rate[0]
    -10.3f,  // pilot depth_low[0]
    30.0f,  // pilot depth_high[0]
    0.5f,  // pilot depth_step[0]
    0.8014128f,  // pilot glide[0]
    0.05f,  // pilot position_walk[0]
    0.002f,  // pilot current_walk[0]
    0.001f,  // pilot factor_walk[0]
    3.0f,  // pilot start_error[0]
    0.1f,  // pilot current_error[0]
    0.1f,  // pilot factor_error[0]
    1.5f,  // pilot fix_noise[0]
    1.5f,  // pilot fix_offset[0]
    0.24f,  // pilot fix_depth[0]
    12.0f,  // pilot fix_error_max[0]
    -5.2319064f,  // pilot air_low[0]
    0.73139656f,  // pilot air_high[0]
    0.1663f,  // pilot antenna_x[0]
    0.086f,  // pilot antenna_z[0]
    0.1f,  // pilot period[0]
    0.298f,  // pilot speed[0]
    2.0f,  // pilot frequency[0]
    0.27925268f,  // pilot swing[0]
    0.0f,  // pilot lag[0]
    0.43633232f,  // pilot swing[1]
    0.0f,  // pilot lag[1]
    0.347f,  // pilot speed[1]
    3.0f,  // pilot frequency[1]
    0.27925268f,  // pilot swing[2]
    0.0f,  // pilot lag[2]
    0.43633232f,  // pilot swing[3]
    0.0f,  // pilot lag[3]
    0.13962634f,  // pilot bias_max[0]
    0.3811799f,  // pilot bend_max[0]
    0.20943952f,  // pilot bias_max[1]
    0.65345126f,  // pilot bend_max[1]
    1.1183531f,  // pilot curvature[0]
    0.4f,  // pilot heading_rate[0]
    0.29670596f,  // pilot turn_max[0]
    0.5f,  // pilot rate_gain[0]
    0.1f,  // pilot heading_integral[0]
    0.1f,  // pilot speed_min[0]
    4.0f,  // pilot lookahead[0]
    1.5f,  // pilot depth_lookahead[0]
    0.5f,  // pilot pitch_max[0]
    0.20791169f,  // pilot climb_max[0]
    2.0f,  // pilot climb_lead[0]
    0.6f,  // pilot climb_gain[0]
    0.05f,  // pilot depth_integral[0]
    0.0f,  // pilot pitch_gain[0]
    0.4f,  // pilot pitch_damping[0]
    0.7853982f,  // pilot fin_angle_max[0]
    0.12f,  // pilot surface_depth[0]
    3.0f,  // pilot fence_margin[0]
    12.0f,  // pilot error_max[0]
    4.0f,  // pilot error_near[0]
    40.0f,  // pilot error_lost[0]
    1.8973666f,  // pilot error_fix[0]
    0.24f,  // pilot depth_tolerance[0]
    180.0f,  // pilot arrival_timeout[0]
    0.02f,  // pilot drift_error_max[0]
    60.0f,  // pilot fix_timeout[0]
    180.0f,  // pilot retry[0]
    2.0f,  // pilot lost_after[0]
    120.0f,  // pilot compass_timeout[0]
    0.026176948f,  // pilot fin_tilt[0]
    0.20943952f,  // pilot fin_min[0]
    10.0f,  // pilot fin_after[0]
    0.5235988f,  // pilot single_fin_max[0]
    25.0f,  // pilot response_time[0]
    0.3f,  // pilot response_depth[0]
    0.34906584f,  // pilot blind_fin[0]
    0.25f,  // pilot slow[0]
    12.24f,  // pilot battery_empty[0]
    4.56f,  // pilot battery_span[0]
    0.108024694f,  // pilot battery_drop[0]
    15525.11f,  // pilot endurance[0]
    30.0f,  // pilot overhead[0]
    32768.0f,  // calibration bend_zero[0]
    32768.0f,  // calibration bend_zero[1]
    5.9921265e-05f,  // calibration bend_scale[0]
    5.9921265e-05f,  // calibration bend_scale[1]
    15291.733f,  // calibration pressure_zero[0]
    15291.733f,  // calibration pressure_zero[1]
    15291.733f,  // calibration pressure_zero[2]
    15291.733f,  // calibration pressure_zero[3]
    11.444092f,  // calibration pressure_scale[0]
    11.444092f,  // calibration pressure_scale[1]
    11.444092f,  // calibration pressure_scale[2]
    11.444092f,  // calibration pressure_scale[3]
    32768.0f,  // calibration current_zero[0]
    32768.0f,  // calibration current_zero[1]
    32768.0f,  // calibration current_zero[2]
    32768.0f,  // calibration current_zero[3]
    0.00019073486f,  // calibration current_scale[0]
    0.00019073486f,  // calibration current_scale[1]
    0.00019073486f,  // calibration current_scale[2]
    0.00019073486f,  // calibration current_scale[3]
    0.0f,  // calibration rate_zero[0]
    0.0f,  // calibration rate_zero[1]
    0.0f,  // calibration rate_zero[2]
    0.0010650635f,  // calibration rate_scale[0]
    0.0010650635f,  // calibration rate_scale[1]
    0.0010650635f,  // calibration rate_scale[2]
    0.0f,  // calibration acceleration_zero[0]
    0.0f,  // calibration acceleration_zero[1]
    0.0f,  // calibration acceleration_zero[2]
    0.0047912598f,  // calibration acceleration_scale[0]
    0.0047912598f,  // calibration acceleration_scale[1]
    0.0047912598f,  // calibration acceleration_scale[2]
    6553.6f,  // calibration voltage_zero[0]
    0.00038146973f,  // calibration voltage_scale[0]
    10132.5f,  // calibration depth_zero[0]
    0.001019368f,  // calibration depth_scale[0]
    0.0f,  // calibration field_zero[0]
    0.0f,  // calibration field_zero[1]
    0.0f,  // calibration field_zero[2]
    6.1035156e-05f,  // calibration field_scale[0]
    6.1035156e-05f,  // calibration field_scale[1]
    6.1035156e-05f,  // calibration field_scale[2]
    0.0f,  // calibration servo_trim[0]
    0.0f,  // calibration servo_trim[1]
    0.0f,  // calibration servo_trim[2]
    0.0f,  // calibration servo_trim[3]
    0.0f,  // calibration servo_trim[4]
    0.0f,  // calibration servo_trim[5]
    1.0f,  // limits manual_timeout[0]
    5.0f,  // limits link_timeout[0]
    60.0f,  // limits home_timeout[0]
    12.0f,  // limits voltage_empty[0]
    5.0f,  // limits voltage_after[0]
    0.8660254f,  // limits tilt_max[0]
    3.0f,  // limits tilt_after[0]
    1.0f,  // limits leak_after[0]
    1.5f,  // limits rise_depth[0]
    10.0f,  // limits depth_max[0]
    4800.0f,  // limits link_rate[0]
    0.75f,  // limits link_share[0]
    1.0f,  // limits system_id[0]
    0.0f,  // limits sign[0]
};

inline constexpr ParameterInfo parameters[] = {
    {"learning", 0.0f, 1.0f, 0.7f, false, 5},
    {"amplitude_0", 0.0f, 0.31764993f, 0.31764993f, false, 12},
    {"amplitude_1", 0.0f, 0.54454273f, 0.54454273f, false, 20},
    {"pressure_soft", 125000.0f, 250000.0f, 250000.0f, false, 74},
    {"pressure_hard", 150000.0f, 300000.0f, 300000.0f, false, 75},
    {"frequency_max", 0.8f, 8.0f, 8.0f, false, 87},
    {"fin_max", 0.0f, 0.7853982f, 0.7853982f, false, 88},
    {"voltage_low", 12.8f, 15.360001f, 12.8f, false, 84},
    {"timeout_ticks", 10.0f, 50.0f, 50.0f, true, 89},
    {"pulse_center", 0.00135f, 0.00165f, 0.0015f, false, 90},
    {"pulse_per_rad", 0.00050960004f, 0.00079625f, 0.000637f, false, 91},
    {"pulse_min", 0.0008f, 0.0011999999f, 0.0008f, false, 92},
    {"pulse_max", 0.00165f, 0.0022f, 0.0022f, false, 93},
    {"slew", 0.015000001f, 0.15f, 0.15f, false, 94},
    {"heading_rate", 0.2f, 0.8f, 0.4f, false, 141},
    {"heading_integral", 0.05f, 0.2f, 0.1f, false, 144},
    {"rate_gain", 0.25f, 1.0f, 0.5f, false, 143},
    {"turn_max", 0.14835298f, 0.5934119f, 0.29670596f, false, 142},
    {"curvature", 0.55917656f, 2.2367063f, 1.1183531f, false, 140},
    {"lookahead", 2.0f, 8.0f, 4.0f, false, 146},
    {"depth_lookahead", 0.75f, 3.0f, 1.5f, false, 147},
    {"depth_integral", 0.025f, 0.1f, 0.05f, false, 152},
    {"climb_lead", 1.0f, 4.0f, 2.0f, false, 150},
    {"climb_gain", 0.3f, 1.2f, 0.6f, false, 151},
    {"pitch_damping", 0.2f, 0.8f, 0.4f, false, 154},
    {"speed_min", 0.05f, 0.2f, 0.1f, false, 145},
    {"surface_depth", 0.06f, 0.24f, 0.12f, false, 156},
    {"fence_margin", 1.5f, 6.0f, 3.0f, false, 157},
    {"error_max", 6.0f, 24.0f, 12.0f, false, 158},
    {"fix_timeout", 30.0f, 120.0f, 60.0f, false, 165},
    {"bend_zero_0", -65536.0f, 65536.0f, 32768.0f, false, 182},
    {"bend_zero_1", -65536.0f, 65536.0f, 32768.0f, false, 183},
    {"bend_scale_0", 1.4980316e-05f, 0.00023968506f, 5.9921265e-05f, false, 184},
    {"bend_scale_1", 1.4980316e-05f, 0.00023968506f, 5.9921265e-05f, false, 185},
    {"pressure_zero_0", -65536.0f, 65536.0f, 15291.733f, false, 186},
    {"pressure_zero_1", -65536.0f, 65536.0f, 15291.733f, false, 187},
    {"pressure_zero_2", -65536.0f, 65536.0f, 15291.733f, false, 188},
    {"pressure_zero_3", -65536.0f, 65536.0f, 15291.733f, false, 189},
    {"pressure_scale_0", 2.861023f, 45.776367f, 11.444092f, false, 190},
    {"pressure_scale_1", 2.861023f, 45.776367f, 11.444092f, false, 191},
    {"pressure_scale_2", 2.861023f, 45.776367f, 11.444092f, false, 192},
    {"pressure_scale_3", 2.861023f, 45.776367f, 11.444092f, false, 193},
    {"current_zero_0", -65536.0f, 65536.0f, 32768.0f, false, 194},
    {"current_zero_1", -65536.0f, 65536.0f, 32768.0f, false, 195},
    {"current_zero_2", -65536.0f, 65536.0f, 32768.0f, false, 196},
    {"current_zero_3", -65536.0f, 65536.0f, 32768.0f, false, 197},
    {"current_scale_0", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 198},
    {"current_scale_1", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 199},
    {"current_scale_2", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 200},
    {"current_scale_3", 4.7683716e-05f, 0.00076293945f, 0.00019073486f, false, 201},
    {"voltage_zero", -65536.0f, 65536.0f, 6553.6f, false, 214},
    {"voltage_scale", 9.536743e-05f, 0.0015258789f, 0.00038146973f, false, 215},
    {"rate_zero_0", -327.68f, 327.68f, 0.0f, false, 202},
    {"rate_zero_1", -327.68f, 327.68f, 0.0f, false, 203},
    {"rate_zero_2", -327.68f, 327.68f, 0.0f, false, 204},
    {"rate_scale_0", 0.0009585572f, 0.0011715699f, 0.0010650635f, false, 205},
    {"rate_scale_1", 0.0009585572f, 0.0011715699f, 0.0010650635f, false, 206},
    {"rate_scale_2", 0.0009585572f, 0.0011715699f, 0.0010650635f, false, 207},
    {"accel_zero_0", -327.68f, 327.68f, 0.0f, false, 208},
    {"accel_zero_1", -327.68f, 327.68f, 0.0f, false, 209},
    {"accel_zero_2", -327.68f, 327.68f, 0.0f, false, 210},
    {"accel_scale_0", 0.004312134f, 0.0052703856f, 0.0047912598f, false, 211},
    {"accel_scale_1", 0.004312134f, 0.0052703856f, 0.0047912598f, false, 212},
    {"accel_scale_2", 0.004312134f, 0.0052703856f, 0.0047912598f, false, 213},
    {"depth_zero", 8106.0f, 12159.0f, 10132.5f, false, 216},
    {"depth_scale", 0.00091743114f, 0.0011213047f, 0.001019368f, false, 217},
    {"field_zero_0", -32768.0f, 32768.0f, 0.0f, false, 218},
    {"field_zero_1", -32768.0f, 32768.0f, 0.0f, false, 219},
    {"field_zero_2", -32768.0f, 32768.0f, 0.0f, false, 220},
    {"field_scale_0", 6.1035157e-06f, 0.012207031f, 6.1035156e-05f, false, 221},
    {"field_scale_1", 6.1035157e-06f, 0.012207031f, 6.1035156e-05f, false, 222},
    {"field_scale_2", 6.1035157e-06f, 0.012207031f, 6.1035156e-05f, false, 223},
    {"servo_trim_0", -0.0002f, 0.0002f, 0.0f, false, 224},
    {"servo_trim_1", -0.0002f, 0.0002f, 0.0f, false, 225},
    {"servo_trim_2", -0.0002f, 0.0002f, 0.0f, false, 226},
    {"servo_trim_3", -0.0002f, 0.0002f, 0.0f, false, 227},
    {"servo_trim_4", -0.0002f, 0.0002f, 0.0f, false, 228},
    {"servo_trim_5", -0.0002f, 0.0002f, 0.0f, false, 229},
    {"manual_timeout", 0.1f, 1.0f, 1.0f, false, 230},
    {"link_timeout", 1.0f, 10.0f, 5.0f, false, 231},
    {"home_timeout", 12.0f, 600.0f, 60.0f, false, 232},
    {"voltage_empty", 12.0f, 14.4f, 12.0f, false, 233},
    {"tilt_max", 0.4330127f, 0.8660254f, 0.8660254f, false, 235},
    {"rise_depth", 0.3f, 6.0f, 1.5f, false, 238},
    {"depth_max", 0.5f, 10.0f, 10.0f, false, 239},
    {"link_rate", 300.0f, 115200.0f, 4800.0f, false, 240},
    {"link_share", 0.05f, 1.0f, 0.75f, false, 241},
    {"system_id", 1.0f, 250.0f, 1.0f, true, 242},
    {"sign", 0.0f, 1.0f, 0.0f, true, 243},
};

inline constexpr Description description = {
    "hypertuna", 2, 2, values, 244, parameters, 89, 0x7a36c7d9};

inline constexpr struct {
    int servo[6];
    int analog[11];
    int leak[1];
    int recovery[1];
    int imu_serial, position_serial, radio_serial, radio_baud;
    int fix_ms;      // time between fixes
    float watchdog;  // s
} wiring = {
    {2, 3, 4, 5, 6, 9},
    {14, 15, 16, 17, 20, 21, 22, 23, 24, 25, 26},
    {28},
    {32},
    1, 8, 2, 9600,
    1000,
    0.5f,
};

}  // namespace hypertuna::firmware::robot
// clang-format on
