-- DYN CAN, the protocol of the DYN2 and DYN4 servo drives, for Wireshark and tshark 4.0 or newer.
--
--   tshark -X lua_script:dyn-can.lua -r run.log -Y 'dyn.alarm_code > 0'
--
-- The identifier is drive id << 5 | function code, and a request and its reply share it: which of the two a frame is follows from the
-- frames before it. The fields have the names of `motionctl decode --json` behind `dyn.`, and say the same (docs/interop.md).

local dyn = Proto("dyn", "DYN CAN")

local AS_RECOGNISED, V1_2A, V1_6A = 0, 1, 2
dyn.prefs.revision = Pref.enum("Revision", AS_RECOGNISED,
  "Revision of every drive. As recognised: by the length of its Read_Param_Group3 reply, 1.6A until then",
  { { 1, "As recognised", AS_RECOGNISED }, { 2, "1.2A", V1_2A }, { 3, "1.6A", V1_6A } }, false)
dyn.prefs.reply_ms = Pref.uint("Reply window (ms)", 10, "Milliseconds for which a request waits for its reply")

-- The same frame again within this time was repeated by CAN, or sent twice.
local REPEAT_WINDOW_NS = 200000

-- Fields ----------------------------------------------------------------------------------------------------------------------------

local NAMES = {
  [0x00] = "Set_Origin", "Go_Absolute_Pos_PTP", "Make_LinearLine", "Go_Relative_Pos_PTP", "Make_CircularArc", "Assign_Drive_ID",
  "Read_Drive_ID", "Set_Drive_Config", "Read_Drive_Config", "Read_Drive_Status", "Turn_ConstSpeed", "Square_Wave", "Sin_Wave",
  "SS_Frequency", "General_Read", "ForMotorDefine", "Set_Param_Group1", "Set_Param_Group2", "Set_Param_Group3", "Read_Param_Group1",
  "Read_Param_Group2", "Read_Param_Group3", "Go_Absolute_Pos_Sync", "Go_Relative_Pos_Sync", "Sync_Trigger", "Servo_Disable",
  "Read_Motor_Speed", "Drive_Reset", "Go_Relative_Pos_PD", "Drive_Error", "Echo_Function", "Diagnostic_counter",
}

local fields = {}
local function declare(kind, names)
  for name, label in pairs(names) do
    fields[name] = ProtoField[kind]("dyn." .. name, label)
  end
end
declare("uint8", {
  drive = "Drive (0: all, or one without an id)", function_code = "Function code", drive_id = "Drive id", config = "Configuration byte",
  command_mode = "Command mode (0: RS232 and CAN)", servo_mode = "Servo mode (0: position, 1: speed, 2: torque)",
  frequency_hz = "Frequency in Hz", main_gain = "Main gain", speed_gain = "Speed gain", integration_gain = "Integration gain",
  torque_filter = "Torque filter", max_speed = "Max speed parameter", max_acceleration = "Max acceleration parameter",
  on_pos_range = "On-position range", alarm_code = "Alarm code", answer = "Answer", counter = "Counter",
})
declare("uint16", { gear_number = "Gear number", line_number = "Line number" })
declare("int32", {
  step_counts = "Step in counts", target_counts = "Target in counts", distance_counts = "Distance in counts",
  word_counts = "Word of a line or an arc in counts", speed_rpm = "Speed in r/min", amplitude = "Amplitude (4096 is 180 degrees)",
  position_counts = "Position in counts", torque = "Torque as sent", torque_full_scale = "Torque that stands for the peak current",
  position_or_torque = "Position or torque, its request was not seen",
})
declare("double", { torque_share_clockwise = "Share of the peak current, clockwise", response_us = "Time after the request in us" })
declare("bool", {
  absolute_mode = "Absolute mode", servo_free = "Servo free", absolute = "Starts absolute moves", enable = "Enables the servo",
  on_position = "On position", disabled = "Disabled", motion_busy = "Motion busy", torque_in_doubt = "Torque beyond its full scale",
})
declare("string", {
  direction = "Direction", ["function"] = "Function", reads = "Reads", alarm = "Alarm", drive_error = "Drive error", error = "Error",
  note = "Note",
})
fields.bytes = ProtoField.bytes("dyn.bytes", "Bytes")
local all_fields = {}
for _, field in pairs(fields) do all_fields[#all_fields + 1] = field end
dyn.fields = all_fields

local experts = {
  refused = ProtoExpert.new("dyn.expert.refused", "The drive refused a command", expert.group.RESPONSE_CODE, expert.severity.ERROR),
  alarm = ProtoExpert.new("dyn.expert.alarm", "The drive is in alarm", expert.group.RESPONSE_CODE, expert.severity.ERROR),
  undecodable = ProtoExpert.new("dyn.expert.undecodable", "Does not decode", expert.group.MALFORMED, expert.severity.ERROR),
  note = ProtoExpert.new("dyn.expert.note", "Repeated, late, unasked or not answered", expert.group.SEQUENCE, expert.severity.WARN),
}
local all_experts = {}
for _, one in pairs(experts) do all_experts[#all_experts + 1] = one end
dyn.experts = all_experts

-- Numbers ---------------------------------------------------------------------------------------------------------------------------

-- The whole data field, most significant byte first, two's complement.
local function signed(data)
  local value = 0
  for _, byte in ipairs(data) do value = value * 256 + byte end
  if data[1] >= 128 then value = value - math.floor(256 ^ #data) end
  return value
end

local function bits(byte, first, count)
  return math.floor(byte / 2 ^ first) % math.floor(2 ^ count)
end

local function u16(first, second, is_msb_first)
  if is_msb_first then return first * 256 + second end
  return second * 256 + first
end

-- Messages --------------------------------------------------------------------------------------------------------------------------

-- A reading is a list of { field, value, first byte, bytes }, or nothing and an error.

local function titled(code)
  return string.format("%s (0x%02X)", NAMES[code], code)
end

local function check_length(code, data, least, most)
  if #data >= least and #data <= most then return nil end
  if least == most then return string.format("%s needs %d data bytes, got %d", titled(code), least, #data) end
  return string.format("%s needs %d..=%d data bytes, got %d", titled(code), least, most, #data)
end

local function check_range(what, value, least, most)
  if value >= least and value <= most then return nil end
  return string.format("%s must be %d..=%d, got %d", what, least, most, value)
end

local function check_known(code, byte, first, second)
  if byte == first or byte == second then return nil end
  if second == nil then return string.format("%s knows data 0x%02X, got 0x%02X", titled(code), first, byte) end
  return string.format("%s knows data 0x%02X and 0x%02X, got 0x%02X", titled(code), first, second, byte)
end

local function config_of(byte)
  return {
    { "config", byte, 0, 1 }, { "command_mode", bits(byte, 0, 2), 0, 1 }, { "servo_mode", bits(byte, 3, 2), 0, 1 },
    { "absolute_mode", bits(byte, 2, 1) == 1, 0, 1 }, { "servo_free", bits(byte, 5, 1) == 1, 0, 1 },
  }
end

local GROUP1 = {
  { "main_gain", "main gain" }, { "speed_gain", "speed gain" }, { "integration_gain", "integration gain" },
  { "torque_filter", "torque filter constant" },
}
local GROUP2 = { { "max_speed", "max speed parameter" }, { "max_acceleration", "max acceleration parameter" } }

-- One byte for each parameter, 1 to 127; in a request 0 keeps what is stored, and nothing is shown of it.
local function bytes_of_group(data, parameters, may_keep)
  local reading = {}
  for index, parameter in ipairs(parameters) do
    local value = data[index]
    if value ~= 0 or not may_keep then
      local wrong = check_range(parameter[2], value, 1, 127)
      if wrong then return nil, wrong end
      reading[#reading + 1] = { parameter[1], value, index - 1, 1 }
    end
  end
  return reading
end

-- `first` is where the gear number begins; in a request 0 keeps what is stored, in a reply there may be no line number.
local function group3(on_pos_range, data, first, is_msb_first, may_keep)
  local gear = u16(data[first], data[first + 1], is_msb_first)
  local line = u16(data[first + 2], data[first + 3], is_msb_first)
  local reading = {}
  local parameters = {
    { "on_pos_range", "on-position range", on_pos_range, 1, 127, 0, first - 1, may_keep },
    { "gear_number", "gear number", gear, 500, 16384, first - 1, 2, may_keep },
    { "line_number", "line number", line, 500, 4095, first + 1, 2, true },
  }
  for _, parameter in ipairs(parameters) do
    local field, what, value, least, most, at, count, may_be_0 = table.unpack(parameter)
    if value ~= 0 or not may_be_0 then
      local wrong = check_range(what, value, least, most)
      if wrong then return nil, wrong end
      reading[#reading + 1] = { field, value, at, count }
    end
  end
  return reading, nil, gear, line
end

-- 1.2A: the order in which everything is within its range; two different ones that both are leave it open.
local function group3_of_1_2a(data)
  local msb, msb_wrong, msb_gear, msb_line = group3(data[1], data, 2, true, false)
  local lsb, _, lsb_gear, lsb_line = group3(data[1], data, 2, false, false)
  if msb and lsb and (msb_gear ~= lsb_gear or msb_line ~= lsb_line) then
    return nil, string.format("the gear number is %d or %d, and the document does not state the byte order: "
      .. "fix the byte order of this drive", msb_gear, lsb_gear)
  end
  if not msb and lsb then return lsb end
  return msb, msb_wrong
end

-- 1.6A: exactly one of the two bytes of the on-position range is 0, which tells the order.
local function group3_of_1_6a(data)
  local a, b = data[1], data[2]
  if a >= 1 and a <= 127 and b == 0 then return group3(a, data, 3, false, false) end
  if a == 0 and b >= 1 and b <= 127 then return group3(b, data, 3, true, false) end
  return nil, string.format("ON_POS_RANGE must be 1..=127 in one byte order, got the bytes 0x%02X 0x%02X", a, b)
end

-- Requests --------------------------------------------------------------------------------------------------------------------------

local COUNTS28 = { "position or distance in counts", -134217728, 134217727 }
-- Functions with one number: field, most bytes, name of the quantity, limits.
local NUMBERS = {
  [0x01] = { "target_counts", 4, COUNTS28 }, [0x02] = { "word_counts", 4, COUNTS28 }, [0x03] = { "distance_counts", 4, COUNTS28 },
  [0x04] = { "word_counts", 4, COUNTS28 }, [0x16] = { "target_counts", 4, COUNTS28 }, [0x17] = { "distance_counts", 4, COUNTS28 },
  [0x0A] = { "speed_rpm", 2, { "speed in rpm", -20000, 20000 } },
  [0x0B] = { "amplitude", 3, { "wave amplitude in counts", 0, 4096 } },
  [0x0C] = { "amplitude", 3, { "wave amplitude in counts", 0, 4096 } },
  [0x1C] = { "step_counts", 2, { "PD step in counts", -16384, 16384 } },
}
local REQUEST_BYTES = {
  [0x00] = 1, [0x05] = 1, [0x06] = 0, [0x07] = 1, [0x08] = 0, [0x09] = 0, [0x0D] = 1, [0x0E] = 1, [0x10] = 4, [0x11] = 2, [0x12] = 5,
  [0x13] = 0, [0x14] = 0, [0x15] = 0, [0x18] = 1, [0x19] = 1, [0x1A] = 0, [0x1B] = 1, [0x1E] = 4, [0x1F] = 0,
}
local READS = { [0x1B] = "position", [0x1E] = "torque" }

local function one_byte(field, value) return { { field, value, 0, 1 } } end

local function ranged_byte(field, what, most)
  return function(data)
    local wrong = check_range(what, data[1], 0, most)
    if wrong then return nil, wrong end
    return one_byte(field, data[1])
  end
end

local function selector(first, second, values)
  return function(data, _, code)
    local wrong = check_known(code, data[1], first, second)
    if wrong then return nil, wrong end
    return values(data[1])
  end
end

local REQUESTS = {
  [0x00] = function(data, revision, code)
    local wrong = check_known(code, data[1], revision == V1_2A and 0xFF or 0xAB)
    return not wrong and {} or nil, wrong
  end,
  [0x05] = ranged_byte("drive_id", "stored drive id", 63),
  [0x07] = function(data)
    local wrong = check_range("configuration byte", data[1], 0, 63) or check_range("servo mode", bits(data[1], 3, 2), 0, 2)
    if wrong then return nil, wrong end
    return config_of(data[1])
  end,
  [0x0D] = ranged_byte("frequency_hz", "wave frequency in Hz", 50),
  [0x0E] = selector(0x1B, 0x1E, function(byte) return one_byte("reads", READS[byte]) end),
  [0x10] = function(data) return bytes_of_group(data, GROUP1, true) end,
  [0x11] = function(data) return bytes_of_group(data, GROUP2, true) end,
  [0x12] = function(data) return group3(data[1], data, 2, true, true) end,
  [0x18] = selector(0xFF, 0xEE, function(byte) return one_byte("absolute", byte == 0xFF) end),
  [0x19] = selector(0x00, 0xFF, function(byte) return one_byte("enable", byte == 0x00) end),
  [0x1B] = selector(0xFE, nil, function() return {} end),
  [0x1E] = function() return { { "bytes", nil, 0, 4 } } end,
}

local function is_missing(code, revision)
  if revision == V1_2A then return code == 0x1B end
  return code == 0x02 or code == 0x04
end

local function read_request(code, data, revision)
  if code == 0x0F then return nil, "function code 0x0F is reserved for the factory: never send it" end
  if is_missing(code, revision) then
    return nil, string.format("%s does not exist in revision %s", titled(code), revision == V1_2A and "1.2A" or "1.6A")
  end
  local number = NUMBERS[code]
  if number then
    local field, most, quantity = table.unpack(number)
    local wrong = check_length(code, data, 1, most)
    if wrong then return nil, wrong end
    local value = signed(data)
    wrong = check_range(quantity[1], value, quantity[2], quantity[3])
    if wrong then return nil, wrong end
    return { { field, value, 0, #data } }
  end
  local wrong = check_length(code, data, REQUEST_BYTES[code], REQUEST_BYTES[code])
  if wrong then return nil, wrong end
  if REQUESTS[code] then return REQUESTS[code](data, revision, code) end
  return {}
end

-- Replies ---------------------------------------------------------------------------------------------------------------------------

local ALARMS = { [0] = "no alarm", "lost phase", "over-current", "overheat or over-power", "command refused" }
local POSITION, TORQUE = "position", "torque"

local REPLIES = {
  [0x06] = ranged_byte("drive_id", "stored drive id", 63),
  [0x08] = function(data) return config_of(data[1]) end,
  [0x09] = function(data)
    local byte = data[1]
    local alarm = bits(byte, 2, 3)
    return {
      { "on_position", bits(byte, 0, 1) == 0, 0, 1 }, { "disabled", bits(byte, 1, 1) == 1, 0, 1 }, { "alarm_code", alarm, 0, 1 },
      { "alarm", ALARMS[alarm] or string.format("undocumented alarm %d", alarm), 0, 1 }, { "motion_busy", bits(byte, 5, 1) == 1, 0, 1 },
    }
  end,
  [0x13] = function(data) return bytes_of_group(data, GROUP1, false) end,
  [0x14] = function(data) return bytes_of_group(data, GROUP2, false) end,
  [0x15] = function(data, revision)
    if revision == V1_2A then return group3_of_1_2a(data) end
    return group3_of_1_6a(data)
  end,
  [0x1A] = function(data) return { { "speed_rpm", signed(data), 0, 2 } } end,
  [0x1B] = function(data) return one_byte("answer", data[1]) end,
  [0x1D] = function(data)
    local errors = { [0xFF] = "data error", [0xEE] = "alarm" }
    return one_byte("drive_error", errors[data[1]] or string.format("undocumented error 0x%02X", data[1]))
  end,
  [0x1E] = function() return { { "bytes", nil, 0, 4 } } end,
  [0x1F] = function(data) return one_byte("counter", data[1]) end,
}
local REPLY_BYTES = {
  [0x06] = 1, [0x08] = 1, [0x09] = 1, [0x13] = 4, [0x14] = 2, [0x1A] = 2, [0x1B] = 1, [0x1D] = 1, [0x1E] = 4, [0x1F] = 1,
}
local GENERAL_READ, READ_GROUP3, DRIVE_ERROR = 0x0E, 0x15, 0x1D

local function torque_of(data, revision)
  local raw = signed(data)
  local full_scale = revision == V1_2A and 700 or 981
  local share = raw / full_scale
  -- Counter-clockwise is positive in 1.2A.
  if revision == V1_2A then share = -share end
  return {
    { "torque", raw, 0, #data }, { "torque_full_scale", full_scale, 0, #data }, { "torque_share_clockwise", share, 0, #data },
    { "torque_in_doubt", math.abs(raw) > full_scale, 0, #data },
  }
end

-- `reads` says what a General_Read asked for, nil when nobody knows.
local function read_reply(code, data, revision, reads)
  if code == GENERAL_READ then
    local wrong = check_length(code, data, 1, reads == TORQUE and 2 or 4)
    if wrong then return nil, wrong end
    if reads == TORQUE then return torque_of(data, revision) end
    return { { reads == POSITION and "position_counts" or "position_or_torque", signed(data), 0, #data } }
  end
  local count = REPLY_BYTES[code] or (revision == V1_2A and 5 or 6)
  local wrong = check_length(code, data, count, count)
  if wrong then return nil, wrong end
  return REPLIES[code](data, revision)
end

local function has_reply(code, revision)
  return (REPLIES[code] ~= nil or code == GENERAL_READ) and not is_missing(code, revision)
end

-- Conversation ----------------------------------------------------------------------------------------------------------------------

-- What is remembered of each bus: the revision of each drive, and of each identifier the open request and the latest frame.
local buses = {}
-- What each frame turned out to be. Wireshark passes once in the order of the file, and then as the user clicks.
local verdicts = {}

function dyn.init()
  buses, verdicts = {}, {}
end

local function revision_of(bus, drive, code)
  if dyn.prefs.revision ~= AS_RECOGNISED then return dyn.prefs.revision end
  -- Until the revision is known, a function that only one of them has tells it.
  return drive ~= 0 and bus.revisions[drive] or is_missing(code, V1_6A) and V1_2A or V1_6A
end

local function ms(ns) return string.format("%.3f ms", ns / 1e6) end

local function verdict(direction, reading, wrong, note, response_ns)
  return { direction = direction, reading = reading, wrong = wrong, note = note, response_ns = reading and response_ns }
end

local function as_reply(code, data, revision, reads, note, response_ns)
  local reading, wrong = read_reply(code, data, revision, reads)
  if reading and reading[1] and reading[1][1] == "position_or_torque" then response_ns = nil end
  return verdict("from_drive", reading, wrong, note, response_ns)
end

local function two_way(slot, code, data, revision, at_ns, is_repeated)
  local is_open = slot.asked_ns ~= nil
  local ago_ns = is_open and math.max(0, at_ns - slot.asked_ns) or nil
  local is_late = is_open and ago_ns > dyn.prefs.reply_ms * 1000000
  if is_open and not is_late and read_reply(code, data, revision, slot.reads) then
    slot.asked_ns = nil
    return as_reply(code, data, revision, slot.reads, nil, ago_ns)
  end
  local request = read_request(code, data, revision)
  if request then
    local note = is_open and string.format("asked %s before without a reply", ms(ago_ns)) or nil
    slot.reads = code == GENERAL_READ and READS[data[1]] or nil
    slot.asked_ns = at_ns
    return verdict("to_drive", request, nil, note)
  end
  slot.asked_ns = nil
  local note = nil
  if is_late then
    note = string.format("late: %s after the request", ms(ago_ns))
  elseif not is_open then
    note = "nobody asked: it came twice, or its request was not seen"
  end
  local reads = (is_open or is_repeated) and slot.reads or nil
  return as_reply(code, data, revision, reads, note, ago_ns)
end

local function hear(bus, id, data, at_ns)
  local drive, code = math.floor(id / 32), id % 32
  if code == READ_GROUP3 then
    bus.revisions[drive] = ({ [5] = V1_2A, [6] = V1_6A })[#data] or bus.revisions[drive]
  end
  local revision = revision_of(bus, drive, code)
  local slot = bus.slots[id] or {}
  bus.slots[id] = slot
  local text = table.concat(data, " ")
  local same_ago_ns = slot.last == text and math.max(0, at_ns - slot.last_ns) or nil
  local is_repeated = same_ago_ns ~= nil and same_ago_ns < REPEAT_WINDOW_NS
  slot.last, slot.last_ns = text, at_ns
  local result
  if code == DRIVE_ERROR then
    result = as_reply(code, data, revision, nil, nil, nil)
  elseif has_reply(code, revision) then
    result = two_way(slot, code, data, revision, at_ns, is_repeated)
  else
    local reading, wrong = read_request(code, data, revision)
    result = verdict("to_drive", reading, wrong)
  end
  if is_repeated then
    result.note = string.format("the same frame as %s before: repeated by CAN, or sent twice", ms(same_ago_ns))
  end
  return result
end

-- Display ---------------------------------------------------------------------------------------------------------------------------

local function party(direction, drive)
  if direction == "to_drive" then return drive == 0 and "all drives" or string.format("drive %d", drive) end
  return string.format("drive %d", drive)
end

local function add_experts(tree, value)
  local field, got = value[1], value[2]
  if field == "drive_error" then
    tree:add_proto_expert_info(got == "data error" and experts.refused or experts.alarm, "Drive_Error: " .. got)
  elseif field == "alarm_code" and got ~= 0 then
    tree:add_proto_expert_info(got == 4 and experts.refused or experts.alarm, "alarm: " .. (ALARMS[got] or "undocumented"))
  end
end

local function add_values(tree, tvb, reading)
  local words = {}
  for _, value in ipairs(reading) do
    local field, got, first, count = table.unpack(value)
    local range = tvb(first, count)
    if field == "bytes" then
      tree:add(fields.bytes, range)
      got = tostring(range)
    else
      tree:add(fields[field], range, got)
    end
    words[#words + 1] = field .. " " .. (type(got) == "number" and string.format("%.6g", got) or tostring(got))
    add_experts(tree, value)
  end
  return table.concat(words, ", ")
end

local function show(result, id, tvb, pinfo, tree)
  local drive, code = math.floor(id / 32), id % 32
  local subtree = tree:add(dyn, tvb())
  local function add(field, value) return subtree:add(fields[field], value):set_generated() end
  add("drive", drive)
  add("direction", result.direction)
  add("function", NAMES[code])
  add("function_code", code)
  local said = NAMES[code]
  if result.reading then
    local words = add_values(subtree, tvb, result.reading)
    if words ~= "" then said = said .. ": " .. words end
  else
    add("error", result.wrong)
    said = said .. " does not decode: " .. result.wrong
    subtree:add_proto_expert_info(experts.undecodable, result.wrong)
  end
  if result.response_ns then add("response_us", result.response_ns / 1000) end
  if result.note then
    add("note", result.note)
    subtree:add_proto_expert_info(experts.note, result.note)
    said = said .. " [" .. result.note .. "]"
  end
  subtree:append_text(", " .. party(result.direction, drive) .. ", " .. said)
  pinfo.cols.protocol = "DYN"
  pinfo.cols.src = result.direction == "to_drive" and "master" or party(result.direction, drive)
  pinfo.cols.dst = result.direction == "to_drive" and party(result.direction, drive) or "master"
  pinfo.cols.info = said
end

-- Frames ----------------------------------------------------------------------------------------------------------------------------

local can_id, is_remote, interface_id = Field.new("can.id"), Field.new("can.flags.rtr"), Field.new("frame.interface_id")
-- A capture of all interfaces has its interface here.
local _, cooked_interface = pcall(Field.new, "sll.ifindex")

local function bus_of()
  local cooked = type(cooked_interface) ~= "string" and cooked_interface() or nil
  local interface = interface_id()
  local name = (interface and tostring(interface.value) or "") .. "/" .. (cooked and tostring(cooked.value) or "")
  buses[name] = buses[name] or { revisions = {}, slots = {} }
  return buses[name]
end

local function bytes_of(tvb)
  local data = {}
  for index = 0, tvb:len() - 1 do data[index + 1] = tvb(index, 1):uint() end
  return data
end

function dyn.dissector(tvb, pinfo, tree)
  -- Several frames may travel in one packet of a gateway; the latest is this one.
  local ids, remotes = { can_id() }, { is_remote() }
  if #ids == 0 or tvb:len() > 8 then return 0 end
  if #remotes > 0 and remotes[#remotes].value then return 0 end
  local id = ids[#ids].value
  local key = string.format("%d/%d", pinfo.number, #ids)
  if not pinfo.visited or verdicts[key] == nil then
    local at_ns = math.floor(pinfo.rel_ts * 1e9 + 0.5)
    verdicts[key] = hear(bus_of(), id, bytes_of(tvb), at_ns)
  end
  show(verdicts[key], id, tvb, pinfo, tree)
  -- 0 would mean that it is not for us, and many requests have no data.
  return math.max(1, tvb:len())
end

-- Every 11-bit identifier is one of these drives.
DissectorTable.get("can.id"):add("0-2047", dyn)
