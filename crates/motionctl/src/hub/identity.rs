//! Whether a node is what its objects are taken for.

use zlac8030l::{NodeId, objects};

use super::bus::Bus;
use super::error::HubError;
use super::state::HubState;
use crate::output::tell;

/// What a ZLAC8030L says of itself (guide section 9).
const DEVICE_TYPE: u32 = 0x0004_0192;
const VENDOR: u32 = 0x100;
const PRODUCT: u32 = 1;

/// Refuses another device, before anything is written to it.
///
/// # Errors
/// [`HubError::OtherDevice`], or as [`Bus::read`].
pub(super) fn require_zlac(bus: &mut Bus, node: NodeId) -> Result<(), HubError> {
    let expected = [
        (objects::DEVICE_TYPE, DEVICE_TYPE),
        (objects::VENDOR_ID, VENDOR),
        (objects::PRODUCT_CODE, PRODUCT),
    ];
    for (object, expected) in expected {
        let actual = bus.read(node, object)?;
        if actual != expected {
            return Err(HubError::OtherDevice {
                node,
                address: object.address(),
                expected: expected.into(),
                actual: actual.into(),
            });
        }
    }
    Ok(())
}

/// Refuses a drive that may not be written to: another device, or one with power.
///
/// # Errors
/// [`HubError::OtherDevice`], [`HubError::Enabled`], or as [`Bus::read`].
pub(super) fn require_settable(bus: &mut Bus, node: NodeId) -> Result<HubState, HubError> {
    require_zlac(bus, node)?;
    let state = HubState::read(bus, node)?;
    if state.enabled {
        return Err(HubError::Enabled { node });
    }
    Ok(state)
}

/// Tells the user when a master was here since the power-on: what it set is in the RAM, and nobody has stored it.
///
/// # Errors
/// As [`Bus::read`].
pub(super) fn tell_of_master(
    bus: &mut Bus,
    node: NodeId,
    consequence: &str,
) -> Result<(), HubError> {
    if bus.read(node, objects::EEPROM_UPDATE)? == objects::EEPROM_UPDATE_OFF {
        tell(format_args!(
            "note: a master has set node {node} up since its power-on (2010h is 1), so its PDOs, heartbeat, ramps and stop options may be that master's: {consequence}. Switch its power off and on first where that is not wanted"
        ));
    }
    Ok(())
}
