// A number that counts when it is confirmed, not while it is typed.
import { useEffect, useRef } from 'preact/hooks'

export function NumberField(props: {
  label: string
  value: number
  /** digits after the point */
  digits?: number
  step?: number
  min?: number
  max?: number
  disabled?: boolean
  change: (value: number) => void
}) {
  const input = useRef<HTMLInputElement>(null)
  const text = props.value.toFixed(props.digits ?? 0)
  const latest = useRef(text)
  latest.current = text
  const show = () => {
    if (input.current) input.current.value = latest.current
  }
  // Only a new value replaces what is being typed.
  useEffect(show, [text])
  return (
    <input
      ref={input}
      type="number"
      class="number"
      aria-label={props.label}
      defaultValue={text}
      step={props.step ?? 1}
      min={props.min}
      max={props.max}
      disabled={props.disabled}
      onChange={(event) => {
        const value = event.currentTarget.valueAsNumber
        if (Number.isFinite(value)) props.change(value)
        // An edit that was refused or limited shows what counts again.
        requestAnimationFrame(show)
      }}
    />
  )
}
