import { useEffect, useState } from 'preact/hooks'

/** Light, dark, or as the system is; kept in the browser. */
export function ThemeButton() {
  const [theme, setTheme] = useState(localStorage.getItem('theme') ?? 'system')
  useEffect(() => {
    localStorage.setItem('theme', theme)
    if (theme === 'system') delete document.documentElement.dataset.theme
    else document.documentElement.dataset.theme = theme
  }, [theme])
  const next = { system: 'dark', dark: 'light', light: 'system' }[theme] ?? 'system'
  const signs: Record<string, string> = { system: '◐', dark: '●', light: '○' }
  return (
    <button
      class="quiet"
      title={`Colours: ${theme}`}
      aria-label={`Colours: ${theme}. Change to ${next}`}
      onClick={() => setTheme(next)}
    >
      {signs[theme]}
    </button>
  )
}
