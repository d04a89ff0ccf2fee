//! The image that takes orders over USB. There is no model of USB: its registers are plain storage, so that nothing of the traffic is shown
//! here. What is shown: the clocks are accepted, the driver starts, and the cycle goes on whatever the thread waits for.

use firmware_tests::{Contact, Rig, Stop, rig};

#[test]
fn the_cycle_goes_on_although_usb_never_answers() {
    let mut rig = Rig::with_numbered_drives(rig::image("link-usb"), 2);
    for contact in [Contact::Stop, Contact::Enable, Contact::Run] {
        rig.close(contact);
    }
    assert_eq!(rig.run_ms(500), Stop::Limit);
    assert!(rig.has_logged("there are no settings"));
    // The cycle shows its four short flashes in two seconds, and feeds the watchdog.
    assert_eq!(rig.lit_ms(), 500);
    assert_eq!(rig.board().resets(), []);
    assert_eq!(rig.from_board().count(), 0);
}
