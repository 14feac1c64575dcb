/* Shared by the tests of port/: a vehicle that the core takes, and frames of the parameter
 * protocol. */
#ifndef PORT_TEST_H
#define PORT_TEST_H

#include <string.h>

#include "sway_ecu.h"
#include "swaywatch_dbc.h"
#include "unity.h"

enum { READ, WRITE, APPLY, STORE, DISCARD, VERSION };

static inline sway_core_config_t good_config(void)
{
    sway_core_config_t config;
    sway_core_defaults(&config);
    config.vehicle.car =
        (sway_car_t){1955000, 2690000, 1302000, 1383000, 2166000, 109300, 185200, 0, 0, 15000, 0};
    config.vehicle.trailer =
        (sway_trailer_t){2, 1880000, 10350000, 124000, 526000, 5073000, 131200, 124400, 0, 0, 0};
    return config;
}

static inline sway_port_frame_t request_frame(uint8_t command, uint16_t index, int32_t value)
{
    static uint8_t counter;
    const struct swaywatch_dbc_sway_parameter_request_t request = {
        .parameter_command = command, .parameter_index = index, .parameter_value = value};
    sway_port_frame_t frame = {.id = SWAYWATCH_DBC_SWAY_PARAMETER_REQUEST_FRAME_ID, .dlc = 8};
    swaywatch_dbc_sway_parameter_request_pack(frame.data, &request, sizeof frame.data);
    sway_e2e_protect(frame.id, counter, frame.data);
    counter = sway_e2e_next(counter);
    return frame;
}

static inline struct swaywatch_dbc_sway_parameter_reply_t reply_of(const sway_port_frame_t *frame)
{
    struct swaywatch_dbc_sway_parameter_reply_t reply;
    TEST_ASSERT_EQUAL_HEX16(SWAYWATCH_DBC_SWAY_PARAMETER_REPLY_FRAME_ID, frame->id);
    TEST_ASSERT_EQUAL_UINT8(8, frame->dlc);
    TEST_ASSERT_TRUE(sway_e2e_check(frame->id, frame->data));
    swaywatch_dbc_sway_parameter_reply_unpack(&reply, frame->data, frame->dlc);
    return reply;
}

static inline struct swaywatch_dbc_sway_fault_report_t report_of(const sway_port_frame_t *frame)
{
    struct swaywatch_dbc_sway_fault_report_t report;
    TEST_ASSERT_EQUAL_HEX16(SWAYWATCH_DBC_SWAY_FAULT_REPORT_FRAME_ID, frame->id);
    TEST_ASSERT_EQUAL_UINT8(8, frame->dlc);
    TEST_ASSERT_TRUE(sway_e2e_check(frame->id, frame->data));
    swaywatch_dbc_sway_fault_report_unpack(&report, frame->data, frame->dlc);
    return report;
}

#endif
