// Checks of an option's value before it is sent: the rules of pipeline/graph/stage_info.cpp in short.
import type { StageOption } from '../../api'

/** "1 to 6 px", "at least 0", or '' */
export function rangeOf(option: StageOption): string {
  if (option.type !== 'int' && option.type !== 'double') return ''
  const unit = option.unit ? ` ${option.unit}` : ''
  const { min, max } = option
  if (min !== undefined && max !== undefined) return `${number(min)} to ${number(max)}${unit}`
  if (min !== undefined) return `at least ${number(min)}${unit}`
  if (max !== undefined) return `at most ${number(max)}${unit}`
  return ''
}

/** Thin groups of three digits, so that 5000000 can be read. */
export function number(value: number): string {
  const [whole, rest] = String(value).split('.')
  if (whole.length < 5 || !/^-?\d+$/.test(whole)) return String(value)
  const grouped = whole.replace(/\B(?=(\d{3})+$)/g, ' ')
  return rest === undefined ? grouped : `${grouped}.${rest}`
}

/** One sentence on what is wrong with the value, or ''. */
export function problemOf(option: StageOption, text: string): string {
  const choices = option.choices ?? []
  if (choices.length > 0 && !choices.includes(text)) return `One of ${choices.join(', ')}.`
  if (option.type !== 'int' && option.type !== 'double') return ''
  const kind = option.type === 'int' ? 'a whole number' : 'a number'
  const pattern = option.type === 'int' ? /^[+-]?\d+$/ : /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i
  const range = rangeOf(option)
  const wanted = range ? `${kind}, ${range}` : kind
  if (!pattern.test(text.trim())) return `“${text.trim()}” is not ${wanted}.`
  const value = Number(text)
  const low = option.min !== undefined && value < option.min
  const high = option.max !== undefined && value > option.max
  return low || high ? `${text.trim()} is out of range: ${range}.` : ''
}

/** Whether two texts mean the same value: "1" and "1.0" do. */
export function sameValue(option: StageOption, one: string, other: string): boolean {
  if (one.trim() === other.trim()) return true
  const numeric = option.type === 'int' || option.type === 'double'
  return numeric && one.trim() !== '' && other.trim() !== '' && Number(one) === Number(other)
}

/** The next value for an arrow key: whole steps, or steps of the number's first digit. */
export function stepped(option: StageOption, text: string, direction: 1 | -1): string {
  const value = Number(text)
  if (!Number.isFinite(value) || text.trim() === '') return text
  const size = Math.abs(value) || 1
  const step = option.type === 'int' ? 1 : 10 ** Math.floor(Math.log10(size) - 0.3)
  const next = Number((value + direction * step).toPrecision(12))
  return String(Math.min(option.max ?? Infinity, Math.max(option.min ?? -Infinity, next)))
}
