"""The autopilot and the power of a table: one system of JSBSim for all aircraft, with the table's gains."""

from __future__ import annotations

from maker.model import finite, product, prop, value
from maker.table import POUND, Piston, Table, Turboprops

PSF_INHG = 2116.2166 / 29.92126
PRESSURE_0_INHG = 29.92126


def pressure_ratio(height: float) -> float:
    """Pressure of the standard atmosphere over that at sea level.  height: m.  ICAO Doc 7488."""
    ratio: float = (1.0 - 0.0065 * height / 288.15) ** 5.255880
    return ratio


def available_element(engine: Turboprops | Piston) -> str:
    """Power available now, W, as a JSBSim element."""
    ratio = f"<quotient>{prop('atmosphere/rho-slugs_ft3')}{prop('atmosphere/rho-sl-slugs_ft3')}</quotient>"
    if isinstance(engine, Turboprops):
        return f"{value(engine.rated_w)}<pow>{ratio}{value(engine.lapse)}</pow>"
    scale, speed = 1e3 * engine.scale, engine.rated_rpm
    boost = engine.rated_inhg / (PRESSURE_0_INHG * pressure_ratio(engine.critical_height_m))
    manifold = product(value(boost / PSF_INHG), prop("atmosphere/P-psf"))
    power = (
        value(scale * (engine.p0 + engine.p1 * engine.p2 * (speed + engine.p3) + engine.p4 + engine.p5 * speed))
        + product(
            value(scale * engine.p1 * (speed + engine.p3)), f"<min>{value(engine.rated_inhg)}{manifold}</min>"
        )
        + product(value(-scale * (engine.p4 + engine.p5 * speed)), ratio)
    )
    return f"<sum>{power}</sum>"


def autopilot_xml(table: Table) -> str:
    """The system file."""
    return f"""<?xml version="1.0"?>
<!-- Written by make.py; do not edit.  Autopilot and power.  Every output is a trim value plus a deviation, so
     that each filter rests at zero in trimmed flight and a trim needs no settling.
     Signs of the surfaces: elevator + trailing edge down, aileron + rolls left, rudder + yaws left.
     Gains in ft, ft/s, rad, W.  Each filter takes its step from the FDM: set it before loading. -->
<system name="autopilot">
  <property value="0">ap/on</property>
  <property value="0">ap/roll-cmd-rad</property>
  <property value="0">ap/h-cmd-ft</property>
  <property value="0">ap/v-cmd-fps</property>
  <property value="0">trim/theta-rad</property>
  <property value="0">trim/elevator-rad</property>
  <property value="0">trim/aileron-rad</property>
  <property value="0">trim/rudder-rad</property>
  <property value="0">trim/power-w</property>
  <property value="0">power/deviation-w</property>
  <property value="0">fuel/burn-lbs_sec</property>

{longitudinal(table)}

{power(table)}

{lateral(table)}
</system>
"""


def longitudinal(table: Table) -> str:
    """Height hold by pitch, pitch hold by elevator."""
    g = table.gains
    return f"""  <channel name="longitudinal">
    <!-- height error to a wanted climb, and what is missing of it -->
    <fcs_function name="ap/climb-error-fps">
      <function><product>
        <property>ap/on</property>
        <difference>
          <min><value>{g.climb_most}</value><max><value>{-g.climb_most}</value>
            <product><value>{g.climb}</value>
              <difference><property>ap/h-cmd-ft</property><property>position/geod-alt-ft</property></difference>
            </product></max></min>
          <property>velocities/h-dot-fps</property>
        </difference>
      </product></function>
    </fcs_function>
    <pid name="ap/pitch-deviation-rad">
      <input>ap/climb-error-fps</input>
      <kp>{g.pitch_proportional}</kp>
      <ki>{g.pitch_integral}</ki>
      <clipto><min>{-g.pitch_most}</min><max>{g.pitch_most}</max></clipto>
    </pid>
    <!-- pitch attitude held; the pitch rate is that of the Euler angle, so that a steady turn does not count -->
    <fcs_function name="fcs/elevator-pos-rad">
      <function><sum>
        <property>trim/elevator-rad</property>
        <product><property>ap/on</property>
          <sum>
            <product><value>{g.elevator_pitch}</value>
              <difference><property>attitude/theta-rad</property><property>trim/theta-rad</property>
                <property>ap/pitch-deviation-rad</property></difference></product>
            <product><value>{g.elevator_rate}</value><property>velocities/thetadot-rad_sec</property></product>
          </sum></product>
      </sum></function>
      <clipto><min>{g.elevator_low}</min><max>{g.elevator_high}</max></clipto>
    </fcs_function>
  </channel>"""


def power(table: Table) -> str:
    """Speed hold by power, what the engine gives, the fuel it burns."""
    g = table.gains
    return f"""  <channel name="power">
    <fcs_function name="ap/speed-error-fps">
      <function><product><property>ap/on</property>
        <difference><property>ap/v-cmd-fps</property><property>velocities/vt-fps</property></difference>
      </product></function>
    </fcs_function>
    <!-- gusts of seconds are not chased -->
    <lag_filter name="ap/speed-error-slow-fps">
      <input>ap/speed-error-fps</input>
      <c1>0.5</c1>
    </lag_filter>
    <pid name="ap/power-deviation-w">
      <input>ap/speed-error-slow-fps</input>
      <kp>{g.power_proportional}</kp>
      <ki>{g.power_integral}</ki>
      <clipto><min>{-g.power_most}</min><max>{g.power_most}</max></clipto>
    </pid>
    <lag_filter name="power/deviation-w">
      <input>ap/power-deviation-w</input>
      <c1>0.7</c1>
    </lag_filter>
    <fcs_function name="power/available-w">
      <function><product>
        {available_element(table.engine)}
        <gt><property>inertia/pointmass-weight-lbs</property><value>0</value></gt>
      </product></function>
    </fcs_function>
    <!-- not limited while trimming (autopilot off), so that a trim finds what it would need -->
    <fcs_function name="power/shaft-w">
      <function>
        <max><value>0</value>
          <min><sum><property>power/available-w</property>
              <product><value>1e8</value><difference><value>1</value><property>ap/on</property></difference></product></sum>
            <sum><property>trim/power-w</property><property>power/deviation-w</property></sum></min></max>
      </function>
    </fcs_function>
    <fcs_function name="fuel/burn-lbs_sec">
      <function><product><property>ap/on</property><property>fuel/specific-lbs_sec_w</property>
        <property>power/shaft-w</property></product></function>
    </fcs_function>
    <fcs_function name="inertia/pointmass-weight-lbs">
      <function><max><value>0</value>
        <difference><property>inertia/pointmass-weight-lbs</property>
          <product><property>fuel/burn-lbs_sec</property><property>simulation/dt</property></product></difference></max>
      </function>
    </fcs_function>
  </channel>"""


def lateral(table: Table) -> str:
    """Roll hold by aileron, yaw damper by rudder."""
    g = table.gains
    sine = f"<sin>{prop('attitude/phi-rad')}</sin>"
    turn = f"<quotient>{product(value(32.174), sine)}{prop('velocities/vt-fps')}</quotient>"
    damper = product(value(g.rudder_rate), f"<difference>{prop('velocities/r-rad_sec')}{turn}</difference>")
    comment = ""
    if g.rudder_side:
        each_pound = g.rudder_side * POUND / table.mass.total_kg
        damper = f"<sum>{damper}{product(value(each_pound), finite('forces/fby-total-lbs', 1e9))}</sum>"
        comment = ", and the side force felt: the ball kept in the middle"
    return f"""  <channel name="lateral">
    <fcs_function name="ap/roll-error-rad">
      <function><product><property>ap/on</property>
        <difference><property>attitude/phi-rad</property><property>ap/roll-cmd-rad</property></difference>
      </product></function>
    </fcs_function>
    <!-- the integral holds the bank of a turn against the stable spiral -->
    <pid name="ap/roll-deviation-rad">
      <input>ap/roll-error-rad</input>
      <kp>{g.aileron_roll}</kp>
      <ki>{g.aileron_integral}</ki>
      <clipto><min>-0.25</min><max>0.25</max></clipto>
    </pid>
    <fcs_function name="fcs/aileron-pos-rad">
      <function><sum>
        <property>trim/aileron-rad</property>
        <product><property>ap/on</property>
          <sum>
            <property>ap/roll-deviation-rad</property>
            <product><value>{g.aileron_rate}</value><property>velocities/p-rad_sec</property></product>
          </sum></product>
      </sum></function>
      <clipto><min>{-g.aileron_most}</min><max>{g.aileron_most}</max></clipto>
    </fcs_function>
    <!-- yaw damper: the yaw rate beyond that of a coordinated turn{comment} -->
    <fcs_function name="fcs/rudder-pos-rad">
      <function><sum>
        <property>trim/rudder-rad</property>
        <product><property>ap/on</property>{damper}</product>
      </sum></function>
      <clipto><min>{-g.rudder_most}</min><max>{g.rudder_most}</max></clipto>
    </fcs_function>
  </channel>"""
