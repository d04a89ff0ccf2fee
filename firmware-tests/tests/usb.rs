//! The image that takes orders over USB. There is no model of USB: its registers are plain storage, so that nothing of the traffic is shown
//! here. What is shown: the clocks are accepted, the driver starts, and the cycle goes on whatever the thread waits for.

use firmware_tests::{Contact, Rig, Stop, rig};

#[test]
fn the_cycle_goes_on_although_usb_never_answers() {
    let mut rig = Rig::with_numbered_drives(rig::image("link-usb"), 2);
    for contact in [Contact::Stop, Contact::Enable, Contact::Run] {
        rig.close(contact);
    }
    // The cycle plays the first two of the eighths of a second that say "no settings", and feeds the watchdog.
    assert_eq!(rig.run_ms(60), Stop::Limit);
    assert_eq!(rig.is_led_lit(), Some(true));
    assert_eq!(rig.run_ms(130), Stop::Limit);
    assert_eq!(rig.is_led_lit(), Some(false));
    assert!(rig.has_logged("there are no settings"));
    assert_eq!(rig.board().resets(), []);
    assert_eq!(rig.from_board().count(), 0);
}
