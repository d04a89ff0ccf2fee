//! The run loop: processor, peripherals, resets.

mod memory;
mod supply;

use unicorn_engine::{Arch, ArmCpuModel, Mode, RegisterARM, Unicorn, uc_error};

use crate::can::Wire;
use crate::chip::Chip;
use crate::cpu::{self, Engine};
use crate::flash_memory::{self, FlashMemory};
use crate::hooks::{self, Leave};
use crate::image::Image;
use crate::load::{Accounts, Load};
use crate::log::{Log, Memory};
use crate::nvic::{HARD_FAULT, SV_CALL};
use crate::soc::{ResetCause, Soc};
use crate::transfers;
use memory::{PAINT, load, map_memory};

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The time is over.
    Limit,
    /// A breakpoint instruction: on a board it would wait for the debugger.
    Breakpoint {
        /// Its address.
        pc: u32,
    },
}

/// A reset during a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reset {
    /// When.
    pub at_ns: u64,
    /// Why.
    pub cause: ResetCause,
}

/// A board that runs an image.
pub struct Board {
    engine: Engine<'static>,
    image: Image,
    flash: FlashMemory,
    sleeping: Option<Leave>,
    /// The processor waits for this address in flash, in the middle of an instruction.
    waits_for: Option<u32>,
    /// A fault while a fault was handled: the processor stands still until a reset.
    locked_up: bool,
    log: Log,
    accounts: Accounts,
    resets: Vec<Reset>,
    faults: Vec<u32>,
}

impl Board {
    /// A board with this chip and a crystal of `hse_hz`, connected to `wire`, that has just got its supply.
    ///
    /// # Errors
    /// When Unicorn fails.
    pub fn new(
        chip: &'static Chip,
        image: Image,
        hse_hz: u64,
        wire: Wire,
    ) -> Result<Self, uc_error> {
        let soc = Soc::new(chip, hse_hz, wire);
        let mut engine = Unicorn::new_with_data(Arch::ARM, Mode::THUMB | Mode::MCLASS, soc)?;
        engine.ctl_set_cpu_model(ArmCpuModel::CORTEX_M4 as i32)?;
        let flash_bytes = u64::from(chip.flash.bytes());
        map_memory(&mut engine, flash_bytes)?;
        hooks::install(&mut engine, &image)?;
        flash_memory::install(&mut engine, flash_bytes)?;
        let mut flash = FlashMemory::default();
        load(&mut engine, &image)?;
        flash.follow(&mut engine);
        cpu::reset(&mut engine);
        Ok(Self {
            engine,
            flash,
            log: Log::new(&image),
            image,
            sleeping: None,
            waits_for: None,
            locked_up: false,
            accounts: Accounts::default(),
            resets: Vec::new(),
            faults: Vec::new(),
        })
    }

    /// Everything but the processor.
    #[must_use]
    pub fn soc(&self) -> &Soc {
        self.engine.get_data()
    }

    /// Everything but the processor, to change it.
    pub fn soc_mut(&mut self) -> &mut Soc {
        self.engine.get_data_mut()
    }

    /// The processor, to add hooks of a test.
    pub fn engine_mut(&mut self) -> &mut Engine<'static> {
        &mut self.engine
    }

    /// The image.
    #[must_use]
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// The log of the firmware.
    #[must_use]
    pub fn log(&self) -> &[String] {
        self.log.lines()
    }

    /// Resets so far.
    #[must_use]
    pub fn resets(&self) -> &[Reset] {
        &self.resets
    }

    /// Addresses of the faults so far.
    #[must_use]
    pub fn faults(&self) -> &[u32] {
        &self.faults
    }

    /// Instructions of each handler so far.
    #[must_use]
    pub fn load_of(&self, exception: u16) -> Load {
        self.accounts
            .loads()
            .get(&exception)
            .copied()
            .unwrap_or_default()
    }

    /// Instructions of every handler that ran, by exception number; 0 is the thread.
    #[must_use]
    pub fn accounts(&self) -> &Accounts {
        &self.accounts
    }

    /// Forgets the instructions of handlers counted so far.
    pub fn clear_accounts(&mut self) {
        self.accounts.clear();
    }

    /// Sets a byte of the firmware's memory, as a debug probe can.
    ///
    /// # Panics
    /// When there is no such symbol: the test expects another image.
    pub fn poke(&mut self, symbol: &str, value: u8) {
        self.poke_bytes(symbol, &[value]);
    }

    /// Sets some bytes of the firmware's memory.
    ///
    /// # Panics
    /// When there is no such symbol: the test expects another image.
    pub fn poke_bytes(&mut self, symbol: &str, bytes: &[u8]) {
        let address = self.image.symbol(symbol);
        let address = address.unwrap_or_else(|| panic!("the image has no symbol {symbol}"));
        let written = self.engine.mem_write(u64::from(address), bytes);
        written.expect("symbols lie in memory");
    }

    /// A word of the firmware's memory, as a debug probe can read it; `None` where there is no memory.
    #[must_use]
    pub fn peek(&self, address: u32) -> Option<u32> {
        let mut bytes = [0; 4];
        self.engine.mem_read(u64::from(address), &mut bytes).ok()?;
        Some(u32::from_le_bytes(bytes))
    }

    /// Most bytes of the stack used so far.
    #[must_use]
    pub fn stack_high_water(&self) -> Option<u32> {
        let stack = self.image.stack()?;
        let mut bytes = vec![0; stack.len()];
        self.engine
            .mem_read(u64::from(stack.start), &mut bytes)
            .ok()?;
        let untouched = bytes.iter().take_while(|&&byte| byte == PAINT).count();
        Some(stack.len() as u32 - untouched as u32)
    }

    /// Forgets how much of the stack was used: the next measure counts from what is in use now.
    ///
    /// # Errors
    /// When Unicorn refuses to write.
    pub fn repaint_stack(&mut self) -> Result<(), uc_error> {
        let Some(stack) = self.image.stack() else {
            return Ok(());
        };
        let pointer = cpu::get(&self.engine, RegisterARM::SP);
        let unused = pointer.clamp(stack.start, stack.end) - stack.start;
        self.engine
            .mem_write(u64::from(stack.start), &vec![PAINT; unused as usize])
    }

    /// Runs until `ns` after power-on. A reset on the way starts the firmware anew and is noted.
    pub fn run_until_ns(&mut self, ns: u64) -> Stop {
        loop {
            let soc = self.engine.get_data_mut();
            soc.limit_ns = ns;
            soc.process();
            if let Some(cause) = soc.take_reset() {
                self.reset(cause);
                continue;
            }
            transfers::carry_out(&mut self.engine);
            if self.soc().now_ns() >= ns {
                self.drain_log();
                return Stop::Limit;
            }
            if let Some(address) = self.waits_for {
                if !self.stalls(address) {
                    self.waits_for = None;
                }
            } else if self.locked_up {
                self.pass_time();
            } else if let Some(exception) = cpu::takeable(&self.engine) {
                if !self.stalls(self.soc().nvic.vector_table()) {
                    self.enter(exception);
                }
            } else if self.wakes()
                && !self.stalls_at_fetch()
                && let Some(stop) = self.execute()
            {
                self.drain_log();
                return stop;
            }
        }
    }

    /// A reset from outside, as by the pin.
    pub fn restart(&mut self, cause: ResetCause) {
        self.reset(cause);
    }

    fn instructions(&self) -> u64 {
        self.engine.get_data().instructions
    }

    fn reset(&mut self, cause: ResetCause) {
        self.drain_log();
        self.log.restart();
        let at_ns = self.soc().now_ns();
        self.resets.push(Reset { at_ns, cause });
        self.soc_mut().reset(cause);
        // An operation of the flash that was cut off has left its traces.
        self.flash.follow(&mut self.engine);
        cpu::reset(&mut self.engine);
        (self.sleeping, self.waits_for, self.locked_up) = (None, None, false);
        let instructions = self.instructions();
        self.accounts.reset(instructions);
    }

    fn enter(&mut self, exception: u16) {
        let instructions = self.instructions();
        if self.sleeping.take().is_some() {
            self.accounts.wake(instructions);
        }
        self.accounts.enter(instructions);
        cpu::enter(&mut self.engine, exception);
    }

    /// Whether the processor is awake; if not, time jumps to what comes next.
    fn wakes(&mut self) -> bool {
        let Some(how) = self.sleeping else {
            return true;
        };
        let instructions = self.instructions();
        let soc = self.engine.get_data_mut();
        let woken = match how {
            Leave::WaitForEvent => core::mem::take(&mut soc.event),
            // An interrupt wakes even when it is masked.
            _ => soc
                .nvic
                .first_pending()
                .is_some_and(|first| first.priority < soc.nvic.execution_priority()),
        };
        if woken {
            self.sleeping = None;
            self.accounts.wake(instructions);
        } else {
            self.pass_time();
        }
        woken
    }

    /// Whether the processor has to wait before it can fetch.
    fn stalls_at_fetch(&mut self) -> bool {
        self.soc().flash.is_changing() && self.stalls(cpu::get(&self.engine, RegisterARM::PC))
    }

    /// Whether the processor has to wait for this address because the flash changes there; if so, time jumps to what comes next.
    fn stalls(&mut self, address: u32) -> bool {
        let soc = self.engine.get_data_mut();
        let stalls = soc.flash.is_busy(address);
        if stalls {
            soc.stall();
        }
        stalls
    }

    /// Time jumps to what comes next.
    fn pass_time(&mut self) {
        let soc = self.engine.get_data_mut();
        let until = soc.deadline.max(soc.now + 1);
        soc.idle += until - soc.now;
        soc.now = until;
    }

    /// Executes instructions until something has to be done; `Some` ends the run.
    fn execute(&mut self) -> Option<Stop> {
        self.flash.follow(&mut self.engine);
        let pc = cpu::get(&self.engine, RegisterARM::PC);
        let result = self.engine.emu_start(u64::from(pc | 1), 0, 0, 0);
        let pc = cpu::get(&self.engine, RegisterARM::PC);
        match (self.soc_mut().leave.take(), result) {
            (Some(how @ (Leave::WaitForEvent | Leave::WaitForInterrupt)), _) => self.sleep(how, pc),
            (Some(Leave::Return), _) => {
                let instructions = self.instructions();
                let exception = cpu::leave(&mut self.engine, pc | 1);
                self.accounts.leave(exception, instructions);
            }
            (Some(Leave::SupervisorCall), _) => self.soc_mut().nvic.pend(SV_CALL),
            (Some(Leave::Breakpoint), _) => return Some(Stop::Breakpoint { pc }),
            (Some(Leave::Yield), _) => {
                cpu::set(&mut self.engine, RegisterARM::PC, (pc + 2) | 1);
            }
            // The instruction is executed again when the flash is free.
            (Some(Leave::FlashBusy(address)), _) => self.waits_for = Some(address),
            (None, Ok(())) => {}
            (Some(Leave::Fault(_)), _) | (None, Err(_)) => self.fault(pc),
        }
        None
    }

    fn sleep(&mut self, how: Leave, pc: u32) {
        cpu::set(&mut self.engine, RegisterARM::PC, (pc + 2) | 1);
        self.drain_log();
        let instructions = self.instructions();
        let soc = self.engine.get_data_mut();
        if how == Leave::WaitForEvent && core::mem::take(&mut soc.event) {
            return;
        }
        if soc.nvic.nesting() == 0 {
            self.accounts.sleep(instructions);
        }
        self.sleeping = Some(how);
    }

    /// An undefined instruction, or memory that is not there: the handler of the hard fault runs next.
    fn fault(&mut self, pc: u32) {
        self.faults.push(pc);
        if self.soc().nvic.is_active(HARD_FAULT) {
            self.locked_up = true;
        } else {
            self.soc_mut().nvic.pend(HARD_FAULT);
        }
    }

    fn drain_log(&mut self) {
        self.log.drain(&mut ProbeMemory(&mut self.engine));
    }
}

/// Memory through a debug probe: it works beside the processor.
struct ProbeMemory<'a>(&'a mut Engine<'static>);

impl Memory for ProbeMemory<'_> {
    fn read(&self, address: u32, bytes: &mut [u8]) {
        // Outside of memory a probe reads nothing.
        if self.0.mem_read(u64::from(address), bytes).is_err() {
            bytes.fill(0);
        }
    }

    fn write_word(&mut self, address: u32, value: u32) {
        // It was read from there just now.
        let _ = self.0.mem_write(u64::from(address), &value.to_le_bytes());
    }
}
